"""`eyehand chart segmentation`: time against accuracy over its dials, beside other methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from eyehand.apps.perceived_frame import load_kernels
from eyehand.apps.run_folder import claim_folder
from eyehand.perception import DepthFrame, SegmentationOptions, segment
from eyehand.perception.segmentation import FRONT_FORMAT, STORED_FRONT

from ..bench.chart_style import Provenance
from ..bench.comparison import Method
from ..bench.dial_chart import ChartWords, DialChart, FrontPlace, check_chart_arguments
from ..bench.dials import DialBoard, DialSetting
from .baselines import BASELINES, Baseline
from .comparison import compare_segmentations
from .kinds import SYNTHETIC_SOURCE, KindFrame, KindOptions, open_kinds

OWN = "eyehand"
"""Name of our method in the chart."""
QUICK_FRAMES = 1
ROUNDS, QUICK_ROUNDS = 2, 1
"""Runs of each frame at each setting. The fastest time counts."""
WORDS = ChartWords(
    title="Segmentation: time against accuracy",
    gain="worst_kinds_pct",
    accuracy="score, worst 3 kinds",
    # One object of 51 in the smallest of the worst kinds changes the mean of three by this much.
    same_gain_pct=0.65,
    columns={"worst_kinds_pct": "worst 3", "all_kinds_pct": "all"},
    caption="mean score of the three worst kinds, and of all kinds, %",
    min_shown_pct=10.0,
)
PLACE = FrontPlace("segmentation", FRONT_FORMAT, STORED_FRONT, "SegmentationOptions")


def chart_segmentation(
    data: Annotated[KindOptions | None, Parameter(name="*", group="Data")] = None,
    *,
    quick: bool = False,
    baselines: bool = True,
    store: bool = False,
    out: Path = Path("out/chart_segmentation"),
    json: bool = False,
) -> int:
    """Chart time against accuracy of the segmentation over its dials, beside other methods.

    The accuracy of a setting is the mean score of the three worst kinds of data. Prints a table.
    Writes the chart segmentation.png and its figures segmentation.csv.

    Parameters
    ----------
    data
        Kinds of data: all synthetic families, and real frames where folders are given.
    quick
        Use few settings, one setting per baseline and 1 frame per kind.
    baselines
        Chart other methods too.
    store
        Store the front for SegmentationOptions.for_budget.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    data = data or KindOptions()
    if quick and data.frames is None:
        data = replace(data, frames=QUICK_FRAMES)
    check_chart_arguments("--frames", data.frames, data.seed, store=store, quick=quick)
    frames = open_kinds(data)
    claim_folder(out)
    load_kernels()
    settings = BOARD.settings(quick=quick)
    methods = [_own(setting) for setting in settings]
    for baseline in BASELINES if baselines else ():
        methods += _baseline_methods(baseline, quick=quick)
    results = compare_segmentations(methods, frames, QUICK_ROUNDS if quick else ROUNDS)
    kinds = list(dict.fromkeys(frame.kind for frame in frames))
    made = Provenance(_data_name(frames), data.seed, len(frames))
    chart = DialChart(WORDS, settings, results[: len(settings)], results[len(settings) :], made)
    chart.publish(out, PLACE, store=store, json=json, kinds=kinds, frames=made.frames)
    return 0


def _data_name(frames: Sequence[KindFrame]) -> str:
    """Name the kinds of data; synthetic ones are counted."""
    families = dict.fromkeys(frame.kind for frame in frames if frame.source == SYNTHETIC_SOURCE)
    real = dict.fromkeys(frame.kind for frame in frames if frame.source != SYNTHETIC_SOURCE)
    synthetic = f"{len(families)} synthetic kinds"
    return ", ".join([synthetic, *real] if families else real)


def _own(setting: DialSetting[SegmentationOptions]) -> Method:
    return Method(OWN, setting.name, partial(_labels, options=setting.options))


def _labels(frame: DepthFrame, *, options: SegmentationOptions) -> NDArray[np.int32]:
    return segment(frame, options).labels


def _baseline_methods(baseline: Baseline, *, quick: bool) -> list[Method]:
    values = baseline.settings[len(baseline.settings) // 2 :][:1] if quick else baseline.settings
    return [
        Method(baseline.name, f"{baseline.dial} {value:g}", partial(_run_baseline, baseline, value))
        for value in values
    ]


def _run_baseline(baseline: Baseline, value: float, frame: DepthFrame) -> NDArray[np.int32]:
    return baseline.run(frame, value)


STAGES: dict[str, bool] = dict.fromkeys(
    ("median", "shift_windows", "join_open", "join_occluded", "colour_edges"), False
)
"""Settings that switch off all stages that are on by default."""

BOARD = DialBoard(
    default=SegmentationOptions(),
    dials={
        "stride": (1, 2, 3, 4),
        "window": (5, 7, 9, 11, 13),
        "threads": (1, 2),
        "median": (True, False),
        "shift_windows": (True, False),
        "join_open": (True, False),
        "join_occluded": (True, False),
        "colour_edges": (True, False),
        "split_solids": (False, True),
    },
    # A larger stride needs a smaller window. Threads save time on idle cores only, and no setting
    # with two was on a front. Without the stages the time is shortest.
    crosses=(
        {"stride": (1, 2, 3, 4), "window": (5, 7, 9, 11, 13)},
        {"stride": (1, 2, 3, 4), "shift_windows": (False,), "window": (5, 9)},
        {"stride": (1, 2, 3, 4), **dict.fromkeys(STAGES, (False,))},
    ),
    quick={"stride": (1, 2, 4), "window": (5,), "threads": (2,), "shift_windows": (False,)},
    words={
        ("threads", 1): "1 thread",
        ("threads", 2): "2 threads",
        ("median", False): "no median",
        ("shift_windows", False): "no shift",
        ("join_open", False): "hollow objects not joined",
        ("join_occluded", False): "occluded parts not joined",
        ("colour_edges", False): "no colour",
        ("split_solids", True): "solids split",
        ("median", True): "median",
        ("shift_windows", True): "shift",
        ("join_open", True): "hollow objects joined",
        ("join_occluded", True): "occluded parts joined",
        ("colour_edges", True): "colour",
        ("split_solids", False): "no solid split",
    },
    bare=STAGES,
)
"""The options of the segmentation that the chart varies."""
