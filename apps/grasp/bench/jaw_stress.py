"""`eyehand stress grasp --hand panda`: find where grasping with parallel jaws breaks."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from eyehand.errors import InputError
from eyehand.grasping import JawOptions, load_hand

from ...bench.chart_style import GREY, draw_curve
from ...bench.shares import draw_bars, milliseconds, refused_pct
from ...bench.stress import StressArguments, StressStage, run_stress
from ...bench.sweep import Sweep, SweepStep, Trial
from ...bench.sweep_chart import ReportSpec
from ..clutter_round import Changes, clutter_objects, run_clutter_round

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from matplotlib.axes import Axes


RIGHT = "the first grasp removes an object"


def stress_jaws(hand: str, objects: Path, arguments: StressArguments) -> int:
    """Run the first grasp of rounds of the clutter-removal protocol, made harder step by step.

    Objects are packed, the table is known, the depth has `dex` noise.

    Raises
    ------
    InputError
        If the hand is unknown, or the folder has no objects.
    """
    load_hand(hand)
    folder = objects / "packed" if (objects / "packed").is_dir() else objects
    clutter_objects(str(folder), "all")
    return run_stress(jaw_stage(hand, str(folder)), arguments)


def jaw_stage(hand: str, folder: str) -> StressStage[JawOptions]:
    """Return the stress stage of a gripper with the objects of a folder."""
    return StressStage(
        name="grasp",
        sweeps=jaw_sweeps(hand, folder),
        method=JawOptions(),
        report=ReportSpec(
            title=f"Where grasping with the {hand} gripper breaks",
            subtitle="Share of first grasps that remove an object",
            data="clutter-removal protocol, packed objects, one noisy side view, table known",
            case_name="grasp",
            figures=_figures,
            draw=_draw,
            legend=True,
            time_column="cpu ms a grasp",
        ),
        seeds=4,
        quick_seeds=1,
    )


def jaw_sweeps(hand: str, folder: str) -> tuple[Sweep[JawOptions], ...]:
    """Return all sweeps, in reading order."""
    base: dict[str, Any] = {
        "family": "packed", "objects": folder, "noise": "dex", "known_table": True, "hand": hand,
        "max_attempts": 1,
    }  # fmt: skip

    def changed(**changes: float) -> dict[str, Any]:
        return {**base, "changes": asdict(Changes(**changes))}

    rows: tuple[tuple[str, str, str, tuple[float, ...], Callable], ...] = (
        ("calibration", "error of the hand's place", "mm", (0.0, 3.0, 5.0, 10.0, 15.0),
         lambda v: changed(calibration_error=1e-3 * v)),
        ("rotation", "error of the hand's orientation", "°", (0.0, 1.0, 2.0, 5.0, 10.0),
         lambda v: changed(calibration_angle=math.radians(v))),
        ("noise", "depth noise, as a multiple of dex noise", "", (0.0, 1.0, 2.0, 3.0),
         lambda v: changed(noise_scale=v)),
        ("friction", "friction of pads and objects", "", (1.0, 0.6, 0.4, 0.3, 0.2),
         lambda v: changed(friction=v)),
        ("mass", "factor of the objects' masses", "", (0.5, 1.0, 2.0, 4.0, 8.0),
         lambda v: changed(mass_factor=v)),
        ("camera", "line of sight nearer to the vertical than 60°", "°", (0.0, 15.0, 30.0, 45.0),
         lambda v: changed(camera_turned=math.radians(v))),
        ("density", "number of objects", "", (1.0, 3.0, 5.0, 8.0),
         lambda v: {**base, "count": int(v)}),
    )  # fmt: skip
    return tuple(
        # Four grasps do not resolve a bound of 90 %. Nothing is required.
        Sweep(name, axis, unit, values, None, _attempt(trial), RIGHT)
        for name, axis, unit, values, trial in rows
    )


def _attempt(trial: Callable[[float], dict[str, Any]]) -> Callable[[float, int, JawOptions], Trial]:
    def run(value: float, seed: int, _: JawOptions) -> Trial:
        ended = run_clutter_round({**trial(value), "seed": seed})
        if not ended["placed"]:
            raise InputError(f"no object could be placed at seed {seed}, choose another --seed")
        if not ended["attempts"]:
            return Trial(False, ended["ended"], refused=True)
        first = ended["attempts"][0]
        seconds = 1e-3 * (first["perceive_ms"] + first["plan_ms"])
        return Trial(first["success"], first["cause"], seconds=seconds)

    return run


def _figures(step: SweepStep) -> dict[str, Any]:
    return {"refused_pct": round(refused_pct(step), 1), "cpu_ms": milliseconds(step)}


def _draw(axes: Axes, places: Sequence[float], steps: Sequence[SweepStep]) -> None:
    draw_bars(axes, places, [refused_pct(step) for step in steps], "no grasp offered", GREY, 0.6)
    draw_curve(axes, places, [100 * step.pass_rate for step in steps], "first grasp succeeds")
