"""`eyehand experiment cop`: the centre of pressure of a thin probe between tactels (Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.pad import IMAGE_RATE, PlacedObject, pad_scene, probe
from eyehand.tactile import SelectionMatrix, ServoGoal, TactileServo, TouchPhases

from ..bench import Provenance, add_footer, new_chart
from ..bench.chart_style import BLUE, GREY, INK, LINE, VERMILION, add_legend, label_axes
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table
from .arm_rig import ArmRig, RigOptions, SensorName, home_pose
from .commissioning import commissioned
from .press_bench import pressed_memory
from .servo_run import ServoRun, lasting, run_servo
from .trial_arguments import TrialArguments, run_trials

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

POINTS = 51
"""Number of points along each path that the chart and its CSV file show."""

PATH_LENGTH = 0.005
"""Length of the path, m. It joins the centres of two adjacent tactels."""
SPEED = 0.0025
"""Speed of the pad relative to the probe, m/s: 10 µm during the images of one cycle."""
SETTLE = 0.8
"""Time from the landing to the start of the path, s."""
PRESSURE = 1000.0
"""Contact pressure that the servo keeps, Pa."""
GAP = 0.0015
"""Initial distance between pad and probe, m."""


def experiment_cop(arguments: TrialArguments | None = None) -> int:
    """Measure the error of the centre of pressure (COP): where a pad feels a thin probe.

    A simulated arm slides its pad along a fixed probe of 2 mm, from one tactel to the next, while
    the servo keeps 1 kPa. The true positions come from the arm's joints. Writes cop.png, like
    Fig. 5, and cop.csv. Trials that the servo ends early are counted and enter no other figure.
    Runs 20 trials, or 2 with --quick.
    """
    return run_trials(COP, _measure, arguments)


def _measure(plan: TrialPlan, sensor: SensorName = "good") -> ExperimentResult:
    done = [follow_probe(seed, sensor) for seed in plan.seeds()]
    paths, counts = lasting(done)
    row = probe_row(paths) | counts
    table = result_table(
        [row],
        [
            ("", "2 mm probe, error"),
            ("rms", "{error_rms_mm:.3f} mm"),
            ("maximum", "{error_max_mm:.3f} mm"),
            ("along the path, rms", "{along_rms_mm:.3f} mm"),
            ("worst trial, rms", "{worst_path_rms_mm:.3f} mm"),
            ("force", "{force_n:.2f} N"),
        ],
        caption="distance between the estimated centre of pressure and the true position of the "
        f"probe; tactels are 5 mm apart; ended early: {row['ended_early']} {row['outcomes']}",
    )
    data = "2 mm probe at 1 kPa, 16 × 16 tactels of 5 mm, simulated arm and pad"
    return ExperimentResult([row], table, _picture(paths, plan.provenance(data)), _points(paths))


COP = Experiment("cop", _measure, unit="trial", trials=20, quick_trials=2)


def probe_row(paths: Sequence[ProbePath]) -> dict[str, Any]:
    """Return the position errors over all readings of all paths, mm, and the mean force, N."""
    errors = 1e3 * np.concatenate([path.error for path in paths])
    along = 1e3 * np.concatenate([path.estimated[:, 0] - path.real[:, 0] for path in paths])
    return {
        "name": "probe",
        "error_rms_mm": float(np.sqrt(np.mean(errors**2))),
        "error_max_mm": float(errors.max()),
        "along_rms_mm": float(np.sqrt(np.mean(along**2))),
        "worst_path_rms_mm": max(float(np.sqrt(np.mean(p.error**2))) * 1e3 for p in paths),
        "force_n": float(np.mean(np.concatenate([path.force for path in paths]))),
    }


def _points(paths: Sequence[ProbePath]) -> list[dict[str, Any]]:
    return [
        {
            "way": number,
            "real_x_mm": round(1e3 * float(path.real[k, 0]), 4),
            "estimated_x_mm": round(1e3 * float(path.estimated[k, 0]), 4),
            "real_y_mm": round(1e3 * float(path.real[k, 1]), 4),
            "estimated_y_mm": round(1e3 * float(path.estimated[k, 1]), 4),
            "error_mm": round(1e3 * float(path.error[k]), 4),
        }
        for number, path in enumerate(paths)
        for k in _shown(path)
    ]


def _shown(path: ProbePath) -> np.ndarray:
    """Return the indices of the readings that the chart and the CSV file show."""
    return np.linspace(0, len(path.real) - 1, POINTS).round().astype(int)


def _picture(paths: Sequence[ProbePath], provenance: Provenance) -> Figure:
    row = probe_row(paths)
    figure, (left, right) = new_chart(
        "A probe between tactels is located to hundredths of a millimetre",
        f"2 mm probe moved over 5 mm; error {row['error_rms_mm']:.3f} mm rms, "
        f"{row['error_max_mm']:.3f} mm at most",
        columns=2,
        height=5.0,
    )
    ends = np.array([-2.5, 2.5])
    left.plot(ends, ends, color=GREY, linewidth=LINE, label="true")
    for number, path in enumerate(paths):
        true, estimated = 1e3 * path.real[:, 0], 1e3 * path.estimated[:, 0]
        first = number == 0
        if first:
            k = _shown(path)
            left.plot(true[k], estimated[k], ".", color=VERMILION, markersize=5, label="estimated")
        right.plot(
            true,
            estimated - true,
            color=VERMILION if first else BLUE,
            linewidth=1.6 if first else 0.7,
            alpha=1.0 if first else 0.35,
            zorder=3 if first else 2,
            label={0: "path at the left", 1: "other paths"}.get(number),
        )
    right.axhline(0.0, color=INK, linewidth=0.8)
    high = 1.5 * max(float(np.abs(p.estimated - p.real)[:, 0].max()) for p in paths) * 1e3
    right.set_ylim(-high, high)
    for axes, y, panel in (
        (left, "estimated position [mm]", "Estimated position"),
        (right, "estimated minus true [mm]", "Error along the path"),
    ):
        label_axes(axes, "true position [mm]; tactels are at both ends", y, panel=panel)
        axes.set_xticks([-2.5, 0, 2.5], ["−2.5", "0", "2.5"])
        add_legend(axes, where="upper left")
    add_footer(figure, provenance)
    return figure


@dataclass(frozen=True)
class ProbePath:
    """M readings along the path, and the whole run."""

    real: np.ndarray
    """True position of the probe (M, 2) in the pad frame, m, from the arm's joints."""
    estimated: np.ndarray
    """Centre of pressure (M, 2) in the pad frame, m."""
    force: np.ndarray
    """True normal force (M,), N."""
    run: ServoRun
    """The record from the landing on. It has an outcome if the servo ended early."""

    @property
    def error(self) -> np.ndarray:
        """Distance (M,) between estimated and true position, m."""
        return np.linalg.norm(self.estimated - self.real, axis=1)


def follow_probe(seed: int, sensor: SensorName = "good") -> ProbePath:
    """Slide the pad over a fixed upright probe, 2 mm in diameter, with an arm.

    The servo controls the pressure only. An external motion slides the pad along x, so that the
    probe moves from the centre of one tactel to the centre of the next. The position across the
    path is random within one tactel.

    Parameters
    ----------
    seed
        Random seed of the pad's electronics, its noise and the position across the path, >= 0.
    sensor
        Sensor model.
    """
    home = home_pose()
    across = np.random.default_rng(seed).uniform(-0.5, 0.5) * PATH_LENGTH
    start = home.apply(np.array([-0.5 * PATH_LENGTH, across, GAP]))
    placed = PlacedObject(probe(), RigidTransform.from_translation(start))
    options = RigOptions(image_rate=IMAGE_RATE, sensor=sensor, memory=pressed_memory(sensor))
    rig = ArmRig(pad_scene((placed,)), seed=seed, options=options)
    goal, press = ServoGoal(pressure=PRESSURE), SelectionMatrix(press=True)
    servo = TactileServo(goal, press, commissioned(sensor))
    run = run_servo(
        rig,
        TouchPhases(servo),
        SETTLE + PATH_LENGTH / SPEED,
        lambda elapsed: np.array([-SPEED if elapsed >= SETTLE else 0.0, 0, 0, 0, 0, 0]),
    )
    moving = run.time > SETTLE
    # The pad does not rotate, so the axes of the home pose remain the pad's axes.
    real = home.rotation.inv().apply(start - run.position[moving])[:, :2]
    return ProbePath(real, run.centre[moving], run.force[moving], run)
