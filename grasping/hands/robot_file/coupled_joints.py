"""Joints that follow others in a fixed ratio: by equality constraints of joints and of tendons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .links import tendon_joints
from .read_model import Model, load_mujoco


@dataclass(frozen=True, eq=False)
class JointCouplings:
    """Positions of all joints as a linear function of those of the free joints."""

    free: tuple[int, ...]
    """Joints that follow no other one."""
    followers: tuple[int, ...]
    """Joints that follow them."""
    slopes: NDArray[np.float64]
    """Change of each follower with each free joint, (F, N)."""
    offsets: NDArray[np.float64]
    """Position of each follower with all free joints at 0, (F,), m or rad."""

    def complete(self, model: Model, posture: NDArray[np.float64]) -> None:
        """Set the followers in a posture (nq,) whose free joints are set."""
        if self.followers:
            free = posture[model.jnt_qposadr[list(self.free)]]
            places = model.jnt_qposadr[list(self.followers)]
            posture[places] = self.offsets + self.slopes @ free


def joint_couplings(model: Model, joints: list[int]) -> JointCouplings:
    """Return how joints follow each other. Terms above the first power are left out.

    Parameters
    ----------
    model
        The model.
    joints
        Hinges and slides of a hand.
    """
    rows, leading = _rows(model, joints)
    place = {joint: k for k, joint in enumerate(joints)}
    pivots: list[int] = []
    for number in range(len(rows)):
        row = rows[number]
        columns = np.flatnonzero(np.abs(row[:-1]) > 1e-9)
        if not len(columns):
            continue
        wanted = leading[number]
        # A tendon does not say which of its joints follows. The last one is farthest out.
        pivot = place[wanted] if wanted in place and row[place[wanted]] else int(columns[-1])
        rows[number] = row / row[pivot]
        for other in range(len(rows)):
            if other != number:
                rows[other] -= rows[other][pivot] * rows[number]
        pivots.append(pivot)
    used = [row for row in rows if np.abs(row[:-1]).max(initial=0.0) > 1e-9]
    free = [k for k in range(len(joints)) if k not in pivots]
    reduced = np.array(used).reshape(-1, len(joints) + 1)
    return JointCouplings(
        tuple(joints[k] for k in free),
        tuple(joints[k] for k in pivots),
        -reduced[:, free],
        reduced[:, -1],
    )


def _rows(model: Model, joints: list[int]) -> tuple[list[NDArray[np.float64]], list[int]]:
    """Return the equations: coefficients of the joints and the right side; and the follower."""
    kinds = load_mujoco().mjtEq
    rows, leading = [], []
    for equality in range(model.neq):
        kind = int(model.eq_type[equality])
        if not model.eq_active0[equality] or kind not in (kinds.mjEQ_JOINT, kinds.mjEQ_TENDON):
            continue
        one, two = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        # one - one_0 = data[0] + data[1] (two - two_0), of joints or of lengths of tendons.
        constant, slope = (float(value) for value in model.eq_data[equality][:2])
        terms: dict[int, float] = {}
        for item, share in ((one, 1.0), (two, -slope)):
            for joint, weight in _terms(model, kind == int(kinds.mjEQ_TENDON), item).items():
                terms[joint] = terms.get(joint, 0.0) + share * weight
        if not terms or not set(terms) <= set(joints):
            continue
        start = sum(w * float(model.qpos0[model.jnt_qposadr[j]]) for j, w in terms.items())
        row = np.zeros(len(joints) + 1)
        row[[joints.index(joint) for joint in terms]] = list(terms.values())
        row[-1] = start + constant
        rows.append(row)
        leading.append(one if kind == int(kinds.mjEQ_JOINT) else -1)
    return rows, leading


def _terms(model: Model, tendon: bool, item: int) -> dict[int, float]:
    """Return the joints of a joint or of a fixed tendon, with their coefficients."""
    if item < 0:
        return {}
    if not tendon:
        return {item: 1.0}
    joints = tendon_joints(model, item)
    first = int(model.tendon_adr[item])
    return {joint: float(model.wrap_prm[first + k]) for k, joint in enumerate(joints)}
