"""How the arm can brake after its last command, and the bounds of the next one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .braking_kernels import Brake, advance_of, joint_bounds
from .distance_bounds import is_moving, limit_approach
from .packed_options import DT, pack_options
from .safety_kernels import SafetyRows, min_distance_rate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .collision_world import CollisionWorld
    from .options import ControlOptions
    from .proximity import Proximity
    from .robot_state import RobotState


@dataclass(frozen=True, eq=False)
class Braking:
    """The last command, and where the arm stands if it brakes now."""

    motion: NDArray[np.float64]
    """(2, n): velocity of the last command, rad/s, and its acceleration, rad/s²."""
    command: NDArray[np.float64]
    """Velocity (n,) that the brake commands now, rad/s."""
    at_stop: Proximity | None
    """Distances at standstill; None if the arm stands still."""


def brake_from(
    world: CollisionWorld, state: RobotState, motion: NDArray[np.float64], options: ControlOptions
) -> Braking:
    """Return how the arm can brake in a state after its last command, ``motion`` (2, n)."""
    _, _, brake = _joint_bounds(state, motion, state.limits(), pack_options(options), True)
    moving = is_moving(np.asarray(state.q, dtype=np.float64), brake.stop)
    return Braking(motion, brake.command, world.proximity(brake.stop) if moving else None)


def command_rows(
    nominal: NDArray[np.float64],
    state: RobotState,
    proximity: Proximity,
    options: ControlOptions,
    braking: Braking | None,
    *,
    recover: bool,
) -> SafetyRows:
    """Return the bounds of a command, as the kernels of :mod:`distance_bounds` compute them.

    Without ``braking`` the joints may change their velocity at once. The standstill is then the
    present posture, and the bounds are velocity dampers (Faverjon and Tournassoud 1987) in discrete
    time. Inside the margin the distance must grow, or with `recover` false it must not shrink.

    Parameters
    ----------
    nominal
        Desired velocity (n,), rad/s. The bounds are exact for it.
    """
    q = np.asarray(state.q, dtype=np.float64)
    limits = state.limits(instant=braking is None)
    motion = np.zeros((2, len(q))) if braking is None else braking.motion
    packed = pack_options(options)
    low, high, brake = _joint_bounds(state, motion, limits, packed, recover)
    advance_of(np.asarray(nominal, dtype=np.float64), low, high, q, motion, limits, packed, brake)
    at_stop = proximity
    rows, rates = np.zeros((0, len(q))), np.zeros(0)
    if braking is not None and braking.at_stop is not None:
        at_stop, rows = braking.at_stop, proximity.rows
        rates = _rates(proximity, limits, packed, True)
        if not recover:
            rates = np.minimum(rates, rows @ brake.command)
    rows_at_stop = at_stop.rows * (brake.advance / packed[DT])
    rates_at_stop = _rates(at_stop, limits, packed, recover) + rows_at_stop @ brake.command
    return SafetyRows(
        low,
        high,
        np.concatenate([rows, rows_at_stop]),
        np.concatenate([rates, rates_at_stop]),
    )


def bounding_pairs(proximity: Proximity, braking: Braking | None) -> tuple[tuple[str, str], ...]:
    """Return the pair of each row of :func:`command_rows`."""
    if braking is None or braking.at_stop is None:
        return proximity.names
    return (*proximity.names, *braking.at_stop.names)


def _rates(
    proximity: Proximity,
    limits: NDArray[np.float64],
    packed: NDArray[np.float64],
    recover: bool,
) -> NDArray[np.float64]:
    drift = proximity.drift.copy()
    limit_approach(proximity.distance, proximity.rows, drift, limits, packed)
    pairs = zip(proximity.distance.tolist(), drift.tolist(), strict=True)
    rates = [min_distance_rate(distance, drift, packed, recover) for distance, drift in pairs]
    return np.array(rates, dtype=np.float64)


def _joint_bounds(
    state: RobotState,
    motion: NDArray[np.float64],
    limits: NDArray[np.float64],
    packed: NDArray[np.float64],
    recover: bool,
) -> tuple[NDArray[np.float64], NDArray[np.float64], Brake]:
    n = len(state.q)
    low, high = np.empty(n), np.empty(n)
    brake = Brake(np.empty(n), np.empty(n), np.empty(n))
    q = np.asarray(state.q, dtype=np.float64)
    joint_bounds(q, motion, limits, packed, recover, low, high, brake)
    return low, high, brake
