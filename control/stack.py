"""A stack of tasks as joint velocities: each task moves only in what those above leave free."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .tasks import Task

NEAR_SINGULAR = 0.05
"""Singular values below this are damped more the smaller they are: speeds stay bounded."""
LARGEST_DAMPING = 0.05
"""Damping at a singular value of zero."""
LOST = 1e-9
"""Singular values below this are no direction at all."""


def solve_stack(tasks: Sequence[Task], gain: float = 1.0) -> NDArray[np.float64]:
    """Joint velocities (n,), rad/s, that reduce every task's error in order of priority.

    Strict form of eq. 2-3: task k is solved on its Jacobian projected into the null space of
    *all* tasks above it, dq_k = (J_k N)^+ (gain e_k - J_k dq), so that no task disturbs one
    above: N keeps nothing of the directions that those use, damped ones included. The chapter's
    N1 N2 is not the null space of both. Near a singularity the inverse is damped (Nakamura and
    Hanafusa 1986), so that joint speeds neither jump nor run away.

    Raises
    ------
    InputError
        If there is no task, the tasks disagree on the number of joints, or the gain is not a
        finite positive number.
    """
    if not tasks:
        raise InputError("the stack needs at least one task")
    if not 0.0 < gain < float("inf"):
        raise InputError(f"gain must be finite and > 0, got {gain}")
    joints = tasks[0].jacobian.shape[1]
    if any(task.jacobian.shape[1] != joints for task in tasks):
        sizes = [task.jacobian.shape[1] for task in tasks]
        raise InputError(f"all tasks must have the same number of joints, got {sizes}")
    velocity = np.zeros(joints)
    free = np.eye(joints)
    for task in tasks:
        u, s, vt = np.linalg.svd(task.jacobian @ free, full_matrices=False)
        kept = s > LOST
        if not kept.any():
            continue
        u, s, vt = u[:, kept], s[kept], vt[kept]
        damping = LARGEST_DAMPING**2 * np.maximum(1.0 - (s / NEAR_SINGULAR) ** 2, 0.0)
        wanted = gain * task.error - task.jacobian @ velocity
        velocity = velocity + vt.T @ (s / (s**2 + damping) * (u.T @ wanted))
        free = free - vt.T @ vt
    return velocity
