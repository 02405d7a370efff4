"""How the arm can brake after its last command, and the bounds of the next one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .braking_kernels import Brake, advance_of, brake_cycles, braked_posture, joint_bounds
from .distance_bounds import limit_approach
from .packed_options import DAMPER, DT, MARGIN, pack_options
from .safety_kernels import SafetyRows, min_distance_rate
from .way_kernels import way_postures

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
    on_way: tuple[tuple[float, Proximity], ...]
    """Times on the way to standstill, s, and the distances then. The last time is infinite, for
    standstill. Empty if the arm does not move."""


def brake_from(
    world: CollisionWorld, state: RobotState, motion: NDArray[np.float64], options: ControlOptions
) -> Braking:
    """Return how the arm can brake in a state after its last command, ``motion`` (2, n)."""
    _, _, brake = _joint_bounds(state, motion, state.limits(), pack_options(options), True)
    q = np.asarray(state.q, dtype=np.float64)
    count, limits = way_postures(q, brake.stop), state.limits()
    cycles = brake_cycles(brake.command, limits, options.dt)
    way, posture = [], np.empty_like(q)
    for after in [cycles * step // count for step in range(1, count)]:
        braked_posture(q, motion, limits, options.dt, after, posture)
        way.append((options.dt * after, world.proximity(posture)))
    if count:
        way.append((np.inf, world.proximity(brake.stop)))
    return Braking(motion, brake.command, tuple(way))


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
    on_way = ((np.inf, proximity),)
    rows, rates = [], []
    if braking is not None and braking.on_way:
        on_way, now = braking.on_way, proximity.rows
        rates_now = _rates(proximity, limits, packed, True)
        if not recover:
            rates_now = np.minimum(rates_now, now @ brake.command)
        towards_plane = now * (brake.advance / packed[DT])
        left = proximity.distance - packed[MARGIN] + now @ (brake.stop - q)
        damping = packed[DAMPER] / packed[DT]
        rates_plane = towards_plane @ brake.command - damping * np.maximum(left, 0.0)
        rows, rates = [now, towards_plane], [rates_now, rates_plane]
    for time, there in on_way:
        rows_there = there.rows * (np.minimum(brake.advance, time) / packed[DT])
        rows.append(rows_there)
        rates.append(_rates(there, limits, packed, recover) + rows_there @ brake.command)
    return SafetyRows(low, high, np.concatenate(rows), np.concatenate(rates))


def bounding_pairs(proximity: Proximity, braking: Braking | None) -> tuple[tuple[str, str], ...]:
    """Return the pair of each row of :func:`command_rows`."""
    if braking is None or not braking.on_way:
        return proximity.names
    way = [pair for _, there in braking.on_way for pair in there.names]
    return (*proximity.names, *proximity.names, *way)


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
