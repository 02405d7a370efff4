"""Turn a pad with an edge under it, and measure the angle between them (section 4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.pad import PlacedObject, box_edge, pad_scene
from eyehand.tactile import PRESETS, ServoGoal, TactileServo, TouchPhases

from .arm_rig import CYCLE, ArmRig, RigOptions, SensorName, home_pose
from .commissioning import commissioned

FORCE = 3.0
"""Force on the edge, N. It gives about 2 kPa on the narrow imprint."""
GAP = 0.002
"""Distance from the pad to the edge at the start, m."""
MAX_START_DEG, MIN_START_DEG = 60.0, 15.0
"""Range of the angle between edge and pad's y-axis at the start, to either side, degrees."""
ALIGN_SECONDS = 4.0
"""Time for landing and alignment, s. Then the edge turns."""
REST_SECONDS = 1.0
"""Duration at the end of the alignment in which the remaining error is measured, s."""
SWING_DEG, SWING_PERIOD = 40.0, 8.0
"""Amplitude, degrees, and period, s, of the edge's rotation. Its maximum speed is 31°/s."""
DONE = "done"
"""Outcome of a trial that lasted until the end."""
RESPONSE_SHARE = 0.1
"""Share of the first error that remains at the end of the response time."""

_FIGURES = (
    "response_time_s", "steady_state_error_deg", "standard_deviation_deg", "turning_rms_deg",
    "delay_ms", "force_mean_n", "force_std_n",
)  # fmt: skip
"""Measured figures of a row."""


@dataclass(frozen=True)
class EdgeRun:
    """The record of one trial with M cycles."""

    start_deg: float
    """Angle from the pad's y-axis to the edge at the start, degrees."""
    landing: float
    """Time of the first touch, s."""
    times: NDArray[np.float64]
    """(M,), s."""
    edge_deg: NDArray[np.float64]
    """(M,), true direction of the edge in the world frame, degrees."""
    errors_deg: NDArray[np.float64]
    """(M,), true direction of the pad's y-axis minus that of the edge, degrees."""
    forces: NDArray[np.float64]
    """(M,), true force, N."""
    outcome: str
    """`DONE`, or the reason why the servo ended early. The record then ends there."""


def run_edge(seed: int, sensor: SensorName = "good") -> EdgeRun:
    """Land a pad on an edge at an angle, and turn the edge when the pad is aligned."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(MIN_START_DEG, MAX_START_DEG) * rng.choice([-1.0, 1.0])
    home = home_pose()
    y = home.rotation.as_matrix()[:, 1]
    first = np.degrees(np.arctan2(y[1], y[0])) + start
    place = home.translation - [0.0, 0.0, GAP]
    pose = RigidTransform.from_components(place, Rotation.from_euler("z", first, degrees=True))
    scene = pad_scene((PlacedObject(box_edge(), pose, "mocap"),))
    rig = ArmRig(scene, seed=seed, options=RigOptions(sensor=sensor))
    quats = rig.simulation.data.mocap_quat

    def direction(time: float) -> float:
        since = max(time - ALIGN_SECONDS, 0.0)
        # The amplitude grows for one second, so that the speed does not jump.
        return first + SWING_DEG * np.sin(2 * np.pi * since / SWING_PERIOD) * min(since, 1.0)

    def turn(time: float) -> None:
        turned = Rotation.from_euler("z", direction(time), degrees=True)
        quats[0] = turned.as_quat(scalar_first=True)

    servo = TactileServo(ServoGoal(force=FORCE), PRESETS["edge"], commissioned(sensor))
    phases = TouchPhases(servo)
    phases.phase = "hold"
    log: list[tuple[float, float, float, float]] = []
    landing = np.inf
    while rig.time < ALIGN_SECONDS + SWING_PERIOD and phases.phase != "ended":
        servo.side_force = rig.hand.side_force
        step = phases.step(rig.hand.features, CYCLE, measured=rig.hand.twist)
        sample = rig.step(step.twist, move=turn)[-1][0]
        if sample.force > 0.0:
            landing = min(landing, rig.time)
        y = rig.hand.pose.rotation.as_matrix()[:, 1]
        edge = direction(rig.time)
        gap = np.degrees(np.arctan2(y[1], y[0])) - edge
        log.append((rig.time, edge, (gap + 90.0) % 180.0 - 90.0, sample.force))
    times, edges, errors, forces = np.array(log).T
    return EdgeRun(start, landing, times, edges, errors, forces, phases.outcome or DONE)


def edge_row(run: EdgeRun) -> dict[str, Any]:
    """Return the results of a trial; one that ended early has only its start and outcome."""
    row: dict[str, Any] = {"name": f"edge {run.start_deg:+.0f}°", "start_deg": run.start_deg}
    if run.outcome != DONE:
        return row | dict.fromkeys(_FIGURES) | {"outcome": run.outcome}
    early = (run.times > run.landing) & (run.times < ALIGN_SECONDS)
    wrong = np.abs(run.errors_deg[early]) > RESPONSE_SHARE * abs(run.start_deg)
    last = run.times[early][wrong][-1] if wrong.any() else run.landing
    rest = (run.times > ALIGN_SECONDS - REST_SECONDS) & (run.times < ALIGN_SECONDS)
    late = run.times >= ALIGN_SECONDS
    turning = run.errors_deg[late]
    rates = np.gradient(run.edge_deg[late], run.times[late])
    # With a delay T, the error is the rate times T. Least squares gives T.
    delay = -float(rates @ turning) / float(rates @ rates)
    figures = (
        float(last - run.landing),
        float(np.mean(run.errors_deg[rest])),
        float(np.std(run.errors_deg[rest])),
        float(np.sqrt(np.mean(turning**2))),
        1e3 * delay,
        float(run.forces[late].mean()),
        float(run.forces[late].std()),
    )
    return row | dict(zip(_FIGURES, figures, strict=True)) | {"outcome": run.outcome}


def mean_row(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the mean of absolute values over the trials that lasted, and how many these are."""
    done = [row for row in rows if row["outcome"] == DONE]
    mean: dict[str, Any] = {"name": "mean of sizes"}
    for key in ("start_deg", *_FIGURES):
        mean[key] = float(np.mean([abs(row[key]) for row in done])) if done else None
    return mean | {"outcome": f"{len(done)} of {len(rows)} done"}
