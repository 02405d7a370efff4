"""The safety level: bounds, the closest allowed velocity, and non-finite input."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import linprog, minimize, nnls

from eyehand.control.braking import command_rows
from eyehand.control.options import ControlOptions
from eyehand.control.proximity import Proximity
from eyehand.control.robot_state import RobotState
from eyehand.control.safety import safe_motion
from eyehand.control.safety_kernels import RECOVERY_SPEED, TASK_WEIGHT, SafetyRows, satisfies

Array = NDArray[np.float64]
OPTIONS = ControlOptions()
NO_TASK = np.zeros((0, 7))
seeds = st.integers(0, 100_000)


def proximity(distance, rows, drift=None) -> Proximity:
    distance, rows = np.asarray(distance, dtype=float), np.asarray(rows, dtype=float)
    pairs = len(distance)
    points = np.zeros((pairs, 3))
    return Proximity(
        tuple((f"link{i}", f"box{i}") for i in range(pairs)),
        distance,
        points,
        points,
        points,
        rows,
        np.zeros(pairs) if drift is None else np.asarray(drift, dtype=float),
    )


def robot(q, *, limit=2.0, speed=1.0) -> RobotState:
    q = np.asarray(q, dtype=float)
    full = np.ones(len(q))
    return RobotState(
        q, np.zeros(3), np.eye(3), np.zeros((6, len(q))),
        -limit * full, limit * full, 0.0 * full, speed * full,
    )  # fmt: skip


def safety_rows(state, near, options, *, recover=True) -> SafetyRows:
    """Return the bounds of a velocity that may change at once."""
    return command_rows(np.zeros(len(state.q)), state, near, options, None, recover=recover)


def max_violation(velocity: Array, rows: SafetyRows) -> float:
    """Return the largest violation of a bound by a velocity. It is negative inside all bounds."""
    return max(
        (rows.low - velocity).max(),
        (velocity - rows.high).max(),
        (rows.min_rates - rows.rows @ velocity).max(initial=-np.inf),
    )


def random_case(seed: int, *, drift: float = 0.0, inside: float = 0.0):
    """Return a random arm with up to 30 pairs and levers from 1 mm to 2 m."""
    rng = np.random.default_rng(seed)
    pairs = int(rng.integers(0, 31))
    state = replace(robot(rng.uniform(-1.9, 1.9, 7)), speed=rng.uniform(0.2, 2.0, 7))
    rows = rng.normal(size=(pairs, 7)) * 10.0 ** rng.uniform(-3, 0, (pairs, 1))
    distance = OPTIONS.margin + rng.uniform(-inside, 0.03, pairs)
    near = proximity(distance, rows, drift * rng.normal(size=pairs))
    nominal = rng.uniform(0.0, 3.0) * rng.normal(size=7)
    return state, near, nominal, rng.normal(size=(rng.integers(0, 6), 7))


def kkt_gap(velocity: Array, nominal: Array, tasks: Array, rows: SafetyRows) -> float:
    """Return the KKT residual: the part of the gradient that no active bound balances."""
    hessian = np.eye(len(nominal)) + TASK_WEIGHT * tasks.T @ tasks
    gradient = hessian @ (velocity - nominal)
    eye, tolerance = np.eye(len(nominal)), 1e-8
    forces = np.concatenate(
        [
            eye[velocity < rows.low + tolerance],
            -eye[velocity > rows.high - tolerance],
            rows.rows[rows.rows @ velocity < rows.min_rates + tolerance],
        ]
    )
    if len(forces) == 0:
        return float(np.linalg.norm(gradient))
    forces /= np.maximum(np.linalg.norm(forces, axis=1, keepdims=True), 1e-300)
    return float(nnls(forces.T, gradient)[1])


# Bounds and the closest allowed velocity


@given(seed=seeds)
def test_velocity_satisfies_bounds_and_is_closest_to_nominal(seed):
    state, near, nominal, tasks = random_case(seed)
    motion = safe_motion(nominal, tasks, state, near, OPTIONS)
    rows = safety_rows(state, near, OPTIONS)
    assert motion.feasible
    assert max_violation(motion.velocity, rows) < 1e-9
    assert kkt_gap(motion.velocity, nominal, tasks, rows) < 1e-6


def test_velocity_agrees_with_slsqp():
    for seed in range(15):
        state, near, nominal, tasks = random_case(seed)
        rows = safety_rows(state, near, OPTIONS)
        hessian = np.eye(7) + TASK_WEIGHT * tasks.T @ tasks
        other = minimize(
            lambda v, h=hessian, w=nominal: 0.5 * (v - w) @ h @ (v - w),
            np.zeros(7),
            jac=lambda v, h=hessian, w=nominal: h @ (v - w),
            bounds=list(zip(rows.low, rows.high, strict=True)),
            constraints={
                "type": "ineq",
                "fun": lambda v, r=rows: r.rows @ v - r.min_rates,
                "jac": lambda _, r=rows: r.rows,
            }
            if len(rows.min_rates)
            else (),
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 500},
        )
        velocity = safe_motion(nominal, tasks, state, near, OPTIONS).velocity
        assert np.allclose(velocity, other.x, atol=1e-3)
        assert 0.5 * (velocity - nominal) @ hessian @ (velocity - nominal) < other.fun + 1e-6


@given(seed=seeds)
def test_allowed_nominal_velocity_is_unchanged(seed):
    state, near, nominal, tasks = random_case(seed)
    rows = safety_rows(state, near, OPTIONS)
    for _ in range(200):
        if satisfies(nominal, rows):
            break
        nominal = 0.8 * nominal
    motion = safe_motion(nominal, tasks, state, near, OPTIONS)
    assert np.array_equal(motion.velocity, nominal)
    assert motion.feasible
    assert motion.blocking == ()


@given(seed=seeds, inside=st.floats(0.0, 0.03))
def test_zero_velocity_is_allowed_without_moving_obstacles(seed, inside):
    state, near, nominal, tasks = random_case(seed, inside=inside)
    state = replace(state, q=np.random.default_rng(seed).uniform(-2.1, 2.1, 7))
    rows_without_recovery = safety_rows(state, near, OPTIONS, recover=False)
    assert satisfies(np.zeros(7), rows_without_recovery)
    motion = safe_motion(nominal, tasks, state, near, OPTIONS)
    assert motion.feasible
    assert max_violation(motion.velocity, rows_without_recovery) < 1e-9


@given(seed=seeds, drift=st.floats(0.0, 0.5), inside=st.floats(0.0, 0.03))
def test_feasibility_agrees_with_linear_program(seed, drift, inside):
    state, near, nominal, tasks = random_case(seed, drift=drift, inside=inside)
    assume(len(near.distance))
    motion = safe_motion(nominal, tasks, state, near, OPTIONS)
    rows_without_recovery = safety_rows(state, near, OPTIONS, recover=False)
    bounds = list(zip(rows_without_recovery.low, rows_without_recovery.high, strict=True))
    # The largest slack t that all distances can have at once, relative to the row length.
    length = np.linalg.norm(rows_without_recovery.rows, axis=1)
    best = linprog(
        np.array([*np.zeros(7), -1.0]),
        np.column_stack([-rows_without_recovery.rows, length]),
        -rows_without_recovery.min_rates,
        bounds=[*bounds, (None, 1.0)],
    )
    assert best.status == 0
    slack = best.x[-1]
    if slack > 1e-7:
        assert motion.feasible
    elif slack < -1e-7:
        assert not motion.feasible
        assert motion.blocking
    assert np.all(np.isfinite(motion.velocity))
    assert np.all(np.abs(motion.velocity) <= state.speed + 1e-9)
    if motion.feasible:
        assert max_violation(motion.velocity, rows_without_recovery) < 1e-9


def test_correction_uses_joints_that_affect_tasks_least():
    # Both joints move away from the wall. The task depends on the first joint only.
    wall, tasks = proximity([0.01], [[1.0, 1.0]]), np.array([[1.0, 0.0]])
    nominal = np.array([-0.5, 0.0])
    velocity = safe_motion(nominal, tasks, robot([0, 0]), wall, OPTIONS).velocity
    unweighted = safe_motion(nominal, np.zeros((0, 2)), robot([0, 0]), wall, OPTIONS).velocity
    assert np.allclose(unweighted, [-0.25, 0.25])
    change = velocity - nominal
    assert change.sum() == pytest.approx(0.5)
    assert change[1] / change[0] == pytest.approx(1.0 + TASK_WEIGHT)


def test_blocking_names_are_sorted_by_strength():
    near = proximity([0.01, 0.011, 0.2], [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    motion = safe_motion(
        np.array([-0.9, -0.2, 0.1]), np.zeros((0, 3)), robot([0, 0, 0]), near, OPTIONS
    )
    assert motion.blocking == ("link0 near box0", "link1 near box1")
    fast = safe_motion(
        np.full(3, 4.0), np.zeros((0, 3)), robot([0, 1.98, 0]), near, OPTIONS, ("a", "b", "c")
    )
    assert set(fast.blocking) == {
        "joint a at its full speed", "joint b at its limit", "joint c at its full speed",
    }  # fmt: skip


# Simulated motions: walls, corners and joint limits


def simulate(q, nominal, walls, steps, *, options=OPTIONS, **fields) -> Array:
    """Simulate a planar point with a constant nominal velocity. Return the distances (steps, P).

    ``walls(q, t)`` returns its Proximity.
    """
    q, path = np.asarray(q, dtype=float), []
    for step in range(steps):
        near = walls(q, step * options.dt)
        path.append(near.distance)
        motion = safe_motion(
            np.asarray(nominal, dtype=float), np.zeros((0, 2)), robot(q, **fields), near, options
        )
        assert np.all(np.isfinite(motion.velocity))
        q = q + options.dt * motion.velocity
    return np.array(path)


def disc(q: Array, centre: Array, radius: float, velocity: Array | None = None) -> Proximity:
    offset = q - centre
    length = float(np.linalg.norm(offset))
    row = offset / length
    drift = None if velocity is None else [-row @ velocity]
    return proximity([length - radius], row[None], drift)


def corner(q: Array, _time: float) -> Proximity:
    slant = np.array([np.sqrt(0.5), np.sqrt(0.5)])
    return proximity([q[0], slant @ q], np.array([[1.0, 0.0], slant]))


def test_walls_are_approached_without_violation():
    path = simulate([0.3, 0.1], [-1.0, -0.2], corner, 1500)
    assert path.min() >= OPTIONS.margin - 1e-9
    assert path[-1].max() < OPTIONS.margin + 1e-3
    assert np.all(np.diff(path[:, 0]) <= 1e-12)


def test_round_obstacle_is_passed_at_margin():
    path = simulate([0.3, 0.001], [-1.0, 0.0], lambda q, _: disc(q, np.zeros(2), 0.1), 400)
    # The linear model of a round obstacle is conservative.
    assert path.min() >= OPTIONS.margin - 1e-9
    assert path[-1] > 0.2  # it slid around the obstacle


@pytest.mark.parametrize("start", [-0.04, -0.001, 0.0, 0.009])
@pytest.mark.parametrize("nominal", [(-1.0, 0.0), (0.0, 0.0), (0.3, 0.9)])
def test_distance_inside_margin_grows_to_margin(start, nominal):
    def walls(q: Array, _time: float) -> Proximity:
        return disc(q, np.zeros(2), 0.1)

    path = simulate([0.1 + start, 0.0], nominal, walls, 400)[:, 0]
    leaving = path[:-1] < OPTIONS.margin - 1e-4
    assert np.all(np.diff(path)[leaving] > 0.0)
    # Deep inside, the distance grows at the recovery speed at least.
    deep_inside = path[:-1] < OPTIONS.margin - 0.01
    assert np.all(np.diff(path)[deep_inside] >= OPTIONS.dt * RECOVERY_SPEED - 1e-9)
    assert path[-1] >= OPTIONS.margin - 1e-4


def test_fixed_pair_inside_margin_does_not_block_recovery_of_others():
    # The foot stands on the table. It is always inside the margin.
    def walls(q: Array, _time: float) -> Proximity:
        return proximity([0.0, q[0]], [[0.0, 0.0], [1.0, 0.0]])

    path = simulate([-0.02, 0.0], [-1.0, 0.0], walls, 300)
    assert np.all(np.diff(path[:100, 1]) > 0.0)
    assert path[-1, 1] >= OPTIONS.margin - 1e-4


def test_recovery_with_short_lever_uses_full_joint_speed():
    near = proximity([0.0, 0.0], [[0.01, 0.0], [0.0, 1.0]])
    motion = safe_motion(np.zeros(2), np.zeros((0, 2)), robot([0, 0]), near, OPTIONS)
    assert motion.feasible
    assert motion.velocity[0] == pytest.approx(1.0, abs=1e-3)  # the full joint speed
    assert motion.velocity[1] == pytest.approx(RECOVERY_SPEED, abs=1e-3)


def test_distances_in_narrow_gap_do_not_decrease():
    def walls(q: Array, _time: float) -> Proximity:
        return proximity([0.004 + q[0], 0.008 - q[0]], [[1.0, 0.0], [-1.0, 0.0]])

    path = simulate([0.0, 0.0], [1.0, 0.5], walls, 100)
    assert np.all(path >= path[0] - 1e-9)


@pytest.mark.parametrize("start", [2.0, 2.005, 2.3, -2.0, -2.3])
def test_joints_outside_limits_return(start):
    q = np.array([start, 0.5])
    no_pairs = proximity([], np.zeros((0, 2)))
    inside = 2.0 - OPTIONS.limit_margin
    for _ in range(300):
        before = abs(q[0])
        motion = safe_motion(
            np.array([2.0 * np.sign(start), 0.1]), np.zeros((0, 2)), robot(q), no_pairs, OPTIONS
        )
        q = q + OPTIONS.dt * motion.velocity
        assert abs(q[0]) < before or before <= inside + 1e-6
        assert motion.feasible
    assert abs(q[0]) <= inside + 1e-9
    assert abs(q[0]) > inside - 1e-3  # it stays there: the nominal velocity points outwards


def test_joint_range_narrower_than_margins_keeps_joint_at_centre():
    state = replace(robot([0.004]), lower=np.array([-0.005]), upper=np.array([0.005]))
    no_pairs = proximity([], np.zeros((0, 1)))
    for nominal in (-1.0, 0.0, 1.0):
        velocity = safe_motion(
            np.array([nominal]), np.zeros((0, 1)), state, no_pairs, OPTIONS
        ).velocity
        assert velocity[0] == pytest.approx(-OPTIONS.damper / OPTIONS.dt * 0.004)


def test_joints_without_limits_are_unconstrained():
    state = replace(robot([9.0, 0.0], limit=np.inf), speed=np.array([np.inf, 1.0]))
    no_pairs = proximity([], np.zeros((0, 2)))
    nominal = np.array([50.0, 0.0])
    assert np.array_equal(
        safe_motion(nominal, np.zeros((0, 2)), state, no_pairs, OPTIONS).velocity, nominal
    )
    wall = proximity([0.01], [[-1.0, 0.0]])
    velocity = safe_motion(nominal, np.zeros((0, 2)), state, wall, OPTIONS).velocity
    assert np.allclose(velocity, 0.0, atol=1e-9)


def test_joint_with_zero_speed_does_not_move():
    state = replace(robot([0.0, 0.0]), speed=np.array([0.0, 1.0]))
    wall = proximity([0.01], [[1.0, 1.0]])
    motion = safe_motion(np.array([1.0, -1.0]), np.zeros((0, 2)), state, wall, OPTIONS)
    assert motion.feasible
    assert np.allclose(motion.velocity, 0.0, atol=1e-9)


# Moving obstacles


def test_robot_evades_approaching_obstacle():
    velocity = np.array([0.2, 0.0])

    def walls(q: Array, time: float) -> Proximity:
        return disc(q, np.array([-0.3, 0.0]) + time * velocity, 0.1, velocity)

    path = simulate([0.0, 0.0], [0.0, 0.0], walls, 1000)
    assert path.min() >= OPTIONS.margin - 1e-9
    assert path[-1, 0] < OPTIONS.margin + 0.01  # the obstacle pushed it ahead


def test_robot_may_follow_receding_obstacle():
    leaving = proximity([0.01], [[1.0, 0.0]], [0.3])
    motion = safe_motion(np.array([-0.3, 0.0]), np.zeros((0, 2)), robot([0, 0]), leaving, OPTIONS)
    assert np.allclose(motion.velocity, [-0.3, 0.0])
    assert motion.blocking == ()


def test_closing_jaws_are_infeasible_and_keep_joint_speeds():
    jaws = proximity([0.01, 0.01], [[1.0, 0.0], [-1.0, 0.0]], [-0.1, -0.3])
    motion = safe_motion(np.array([0.0, 5.0]), np.zeros((0, 2)), robot([0, 0]), jaws, OPTIONS)
    assert not motion.feasible
    # The smallest violation is equal for both jaws.
    assert motion.velocity[0] == pytest.approx(-0.1, abs=1e-4)
    assert motion.velocity[1] <= 1.0 + 1e-9
    assert set(motion.blocking[:2]) == {"link0 near box0", "link1 near box1"}


def test_minimum_violation_is_measured_in_metres_per_second():
    # |1 - x|² + |1 + x/10|² is minimal at x = 0.9 / 1.01. Per unit of lever, x would be -4.5.
    jaws = proximity([0.01, 0.01], [[1.0, 0.0], [-0.1, 0.0]], [-1.0, -1.0])
    state = robot([0, 0], speed=9.0)
    motion = safe_motion(np.zeros(2), np.zeros((0, 2)), state, jaws, OPTIONS)
    assert not motion.feasible
    assert motion.velocity[0] == pytest.approx(0.9 / 1.01, abs=1e-4)


def test_robot_evades_fast_obstacle_at_full_speed():
    fast = proximity([0.02], [[1.0, 0.0]], [-5.0])
    motion = safe_motion(np.zeros(2), np.zeros((0, 2)), robot([0, 0]), fast, OPTIONS)
    assert not motion.feasible
    assert motion.velocity[0] == pytest.approx(1.0, abs=1e-6)
    assert "link0 near box0" in motion.blocking


def test_obstacle_approaching_fixed_part_is_reported():
    foot = proximity([0.01, 0.01], [[0.0, 0.0], [1.0, 0.0]], [-0.2, 0.0])
    motion = safe_motion(np.array([-1.0, 0.2]), np.zeros((0, 2)), robot([0, 0]), foot, OPTIONS)
    assert not motion.feasible
    assert motion.blocking[0] == "link0 near box0"
    # The other distance is still kept.
    assert motion.velocity[0] == pytest.approx(0.0, abs=1e-5)
    assert motion.velocity[1] == pytest.approx(0.2, abs=1e-5)


# Non-finite input


NON_FINITE = [
    (where, value)
    for where in ("nominal", "tasks", "distance", "rows", "drift", "speed", "upper")
    for value in (np.nan, np.inf, -np.inf)
    if np.isnan(value) or where not in ("speed", "upper")  # these may be infinite
]


@pytest.mark.parametrize(("where", "value"), NON_FINITE)
def test_non_finite_input_stops_robot_and_is_named(where, value):
    nominal, tasks, state = np.array([0.1, 0.1]), np.ones((1, 2)), robot([0, 0])
    near = proximity([0.2, 0.2], np.eye(2))
    non_finite = np.array([0.2, value])
    if where == "nominal":
        nominal = non_finite
    elif where == "tasks":
        tasks = non_finite[None]
    elif where == "rows":
        near = replace(near, rows=np.array([[1.0, 0.0], non_finite]))
    elif where in ("distance", "drift"):
        near = replace(near, **{where: non_finite})
    else:
        state = replace(state, **{where: non_finite})
    motion = safe_motion(nominal, tasks, state, near, OPTIONS)
    assert np.array_equal(motion.velocity, np.zeros(2))
    assert not motion.feasible
    expected = {
        "nominal": "nominal velocity", "tasks": "rows of the tasks", "speed": "joint speed",
        "upper": "joint limit",
    }.get(where, "distance of link1 and box1")  # fmt: skip
    assert expected in motion.blocking[0]


@given(seed=seeds, scale=st.floats(-12.0, 12.0))
def test_input_of_any_scale_gives_velocities_within_limits(seed, scale):
    state, near, nominal, tasks = random_case(seed, drift=0.1, inside=0.02)
    near = replace(near, rows=near.rows * 10.0**scale)
    for far in (nominal, 10.0**scale * nominal):
        velocity = safe_motion(far, tasks, state, near, OPTIONS).velocity
        assert np.all(np.abs(velocity) <= state.speed + 1e-9)
