"""Postures of a gripper from closed to open, by the names of its file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from .jaw_motion import JawMotion

MIN_WIDTH_STEP = 1e-5
"""Minimum difference of the widths of two postures, m."""


@dataclass(frozen=True, eq=False)
class JawPostures:
    """How the joints of a gripper move two jaws.

    Parts of the file without a name have the names ``body_N`` and ``joint_N``. N counts the parts
    of the file from 0, without the world.
    """

    body: str
    """Body that carries the jaws."""
    T_body_tool: RigidTransform
    """Tool frame: z along the approach, x along the closing direction, origin midway between the
    fingertips of the closed gripper."""
    joints: tuple[str, ...]
    """Joints of the gripper in the order of the file."""
    widths: NDArray[np.float64]
    """Distances between the pads, (K,), increasing, m."""
    positions: NDArray[np.float64]
    """Positions of `joints` at each of them, (K, J), m or rad."""
    sides: tuple[tuple[str, ...], tuple[str, ...]]
    """Bodies of the jaws at -x and +x of the tool frame, without those of a linkage behind them."""
    pads: tuple[str, ...]
    """The bodies of the pads: one body for each moving jaw, that at -x first."""


def jaw_postures(motion: JawMotion, origin: NDArray[np.float64]) -> JawPostures:
    """Return the postures of measured jaws.

    Parameters
    ----------
    motion
        The jaws.
    origin
        Origin of the tool frame in the axes of the motion, (3,), m.
    """
    links = motion.shapes.links
    model = links.model
    joints = links.joints(motion.shapes.link_geoms)
    order = np.argsort(motion.gaps, kind="stable")
    gaps = np.maximum(motion.gaps[order], 0.0)
    kept = [0, *(np.flatnonzero(np.diff(np.maximum.accumulate(gaps)) > MIN_WIDTH_STEP) + 1)]
    postures = motion.path[order][kept]
    sides = [
        tuple(_body(model, body) for body in range(model.nbody) if links.of_body[body] in side)
        for side in (set().union(*fingers) for fingers in motion.jaws.fingers)
    ]
    return JawPostures(
        body=_body(model, motion.shapes.base),
        T_body_tool=RigidTransform.from_components(
            motion.axes @ origin, Rotation.from_matrix(motion.axes)
        ),
        joints=tuple(model.joint(joint).name or f"joint_{joint}" for joint in joints),
        widths=gaps[kept],
        positions=postures[:, model.jnt_qposadr[joints]],
        sides=(sides[1], sides[0]),
        pads=tuple(_body(model, side[0]) for side in motion.pads[::-1]),
    )


def _body(model, body: int) -> str:
    return model.body(body).name or f"body_{body - 1}"
