"""Apply the bed's forces to the bodies of the simulation (compiled)."""

from __future__ import annotations

from numba import njit


@njit(cache=True)
def push_bodies(pad, wrenches, bodies, pad_body, centres, pushed, applied, total):
    """Apply the foam's forces to the solids' bodies, and their opposite to the pad's body.

    Parameters
    ----------
    pad
        :class:`PadPose`.
    wrenches
        (K, 6) float64, force (N) and torque about the pad's origin (N m) on each solid, in the
        pad's frame.
    bodies
        (K,) int64, body of each solid.
    pad_body
        Body of the pad.
    centres
        (B, 3) float64, centres of mass in the world, m (``data.xipos``).
    pushed
        (B, 6) float64, what this pad applied to the bodies in the last call; subtracted from
        `applied` and overwritten.
    applied
        (B, 6) float64, force and torque about the centre of mass in the world's axes
        (``data.xfrc_applied``), changed in place.
    total
        (6,) float64, overwritten by the sum of `wrenches`.
    """
    total[:] = 0.0
    for k in range(len(bodies)):
        for i in range(6):
            total[i] += wrenches[k, i]
    for body in range(len(pushed)):
        for i in range(6):
            if pushed[body, i] != 0.0:
                applied[body, i] -= pushed[body, i]
                pushed[body, i] = 0.0
    for k in range(len(bodies)):
        if wrenches[k, 2] != 0.0:
            _push(pad, wrenches[k], 1.0, bodies[k], centres, pushed)
            _push(pad, wrenches[k], -1.0, pad_body, centres, pushed)
    for body in range(len(pushed)):
        for i in range(6):
            if pushed[body, i] != 0.0:
                applied[body, i] += pushed[body, i]


@njit(cache=True)
def _push(pad, wrench, sign, body, centres, pushed):
    fx, fy, fz = _rotate(pad.rotation, wrench[0], wrench[1], wrench[2])
    tx, ty, tz = _rotate(pad.rotation, wrench[3], wrench[4], wrench[5])
    ax = pad.position[0] - centres[body, 0]
    ay = pad.position[1] - centres[body, 1]
    az = pad.position[2] - centres[body, 2]
    pushed[body, 0] += sign * fx
    pushed[body, 1] += sign * fy
    pushed[body, 2] += sign * fz
    pushed[body, 3] += sign * (tx + ay * fz - az * fy)
    pushed[body, 4] += sign * (ty + az * fx - ax * fz)
    pushed[body, 5] += sign * (tz + ax * fy - ay * fx)


@njit(cache=True)
def _rotate(rotation, x, y, z):
    return (
        rotation[0] * x + rotation[1] * y + rotation[2] * z,
        rotation[3] * x + rotation[4] * y + rotation[5] * z,
        rotation[6] * x + rotation[7] * y + rotation[8] * z,
    )
