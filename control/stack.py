"""A stack of tasks as joint velocities: each task moves only in what those above leave free."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .tasks import Task

SINGULAR = 0.02
"""Singular values below this are treated as lost directions."""


def solve_stack(tasks: Sequence[Task], gain: float = 1.0) -> NDArray[np.float64]:
    """Joint velocities (n,), rad/s, that reduce every task's error in order of priority.

    Strict form of eq. 2-3: task k is solved on its Jacobian projected into the null space of
    *all* tasks above it, dq_k = (J_k N)^+ (gain e_k - J_k dq), so that no task disturbs one
    above. The chapter's N1 N2 is not the null space of both.

    Raises
    ------
    InputError
        If there is no task, or the tasks disagree on the number of joints.
    """
    if not tasks:
        raise InputError("the stack needs at least one task")
    joints = tasks[0].jacobian.shape[1]
    if any(task.jacobian.shape[1] != joints for task in tasks):
        sizes = [task.jacobian.shape[1] for task in tasks]
        raise InputError(f"all tasks must have the same number of joints, got {sizes}")
    velocity = np.zeros(joints)
    free = np.eye(joints)
    for task in tasks:
        u, s, vt = np.linalg.svd(task.jacobian @ free, full_matrices=False)
        kept = s > SINGULAR
        if not kept.any():
            continue
        wanted = gain * task.error - task.jacobian @ velocity
        velocity = velocity + vt[kept].T @ ((u[:, kept].T @ wanted) / s[kept])
        free = free - vt[kept].T @ vt[kept]
    return velocity
