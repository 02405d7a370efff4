"""`eyehand chart segmentation`: time against accuracy over its dials, beside other methods."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from eyehand.apps.console import say, tracked
from eyehand.apps.output_files import make_folder
from eyehand.apps.perceived_frame import load_kernels
from eyehand.errors import InputError
from eyehand.perception import segment
from eyehand.perception.segmentation import FRONT_FORMAT, STORED_FRONT

from ..bench import ChartWords, DialChart, FrontPlace, Method, Provenance, check_chart_arguments
from .baselines import BASELINES, Baseline
from .comparison import compare_segmentations
from .dataset import Coding, DatasetOptions, FrameSource, open_dataset
from .dials import BOARD
from .evaluate import SYNTHETIC
from .synthetic_frames import EMPTY_FAMILIES, FAMILIES, synthetic_sources

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, SegmentationOptions

    from ..bench.dials import DialSetting

OWN = "eyehand"
"""Name of our method in the chart."""
SYNTHETIC_FRAMES = 20
"""Default number of synthetic frames."""
SYNTHETIC_NOISE = "realistic"
QUICK_FRAMES = 2
ROUNDS, QUICK_ROUNDS = 3, 1
"""Runs of each frame at each setting. The fastest time counts."""
WORDS = ChartWords(
    title="Segmentation: time against accuracy",
    gain="overlap_f_pct",
    accuracy="overlap F",
    # Its standard error over 45 real frames.
    same_gain_pct=0.15,
    columns={"overlap_f_pct": "F", "boundary_f_pct": "bF", "found_pct": "%75"},
    caption="F, bF: mean overlap and boundary F; %75: objects with F > 75 %; all in %",
    min_shown_pct=40.0,
)
PLACE = FrontPlace("segmentation", FRONT_FORMAT, STORED_FRONT, "SegmentationOptions")
STORED_SIZE = (480, 640)
"""Size (rows, columns) of the frames for which the front is stored, px."""


def chart_segmentation(
    *,
    dataset: str = SYNTHETIC,
    labels: Coding = "plain",
    camera: Path | None = None,
    depth_scale_mm: float | None = None,
    seed: int = 0,
    frames: int | None = None,
    quick: bool = False,
    baselines: bool = True,
    store: bool = False,
    out: Path = Path("out/chart_segmentation"),
    json: bool = False,
) -> int:
    """Chart time against accuracy of the segmentation over its dials, beside other methods.

    Prints a table. Writes the chart segmentation.png and its figures segmentation.csv.

    Parameters
    ----------
    dataset
        Folder of labelled frames as for eyehand evaluate segmentation, or the word synthetic.
    labels
        Coding of the labels in .npz files: plain (object numbers) or osd.
    camera
        Camera file of the frames. Default: the camera in the files, or a camera file beside them.
    depth_scale_mm
        Millimetres per unit of integer depth in .npz files. Default: the unit in the files.
    seed
        First seed of synthetic scenes.
    frames
        Number of frames, spread evenly over the data set. Default: all of a folder, 20 synthetic.
    quick
        Use few settings, one setting per baseline and 2 frames. Takes seconds, not minutes.
    baselines
        Chart other methods too.
    store
        Store the front for SegmentationOptions.for_budget.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    check_chart_arguments("--frames", frames, seed, store=store, quick=quick)
    synthetic = dataset == SYNTHETIC
    sources = (
        _synthetic(frames, seed, quick=quick)
        if synthetic
        else _spread(
            open_dataset(Path(dataset), DatasetOptions(camera, depth_scale_mm, labels)),
            QUICK_FRAMES if quick and frames is None else frames,
        )
    )
    first = sources[0].load()
    for note in first.assumed:
        say(note)
    if store and first.frame.depth.shape != STORED_SIZE:
        raise InputError(
            f"--store is for frames of {STORED_SIZE[1]}x{STORED_SIZE[0]} px, {sources[0].name} "
            f"has {first.frame.depth.shape[1]}x{first.frame.depth.shape[0]}"
        )
    make_folder(out)
    load_kernels()
    settings = BOARD.settings(quick=quick)
    methods = [_own(setting) for setting in settings]
    for baseline in BASELINES if baselines else ():
        methods += _baseline_methods(baseline, quick=quick)
    results = compare_segmentations(
        methods,
        tracked(sources, "segmenting", len(sources)),
        QUICK_ROUNDS if quick else ROUNDS,
    )
    data = _data_name(dataset, sources, synthetic=synthetic)
    made = Provenance(data, seed if synthetic else None, len(sources))
    chart = DialChart(WORDS, settings, results[: len(settings)], results[len(settings) :], made)
    chart.publish(out, PLACE, store=store, json=json, dataset=dataset, frames=made.frames)
    return 0


def _synthetic(frames: int | None, seed: int, *, quick: bool) -> list[FrameSource]:
    wanted = frames or (QUICK_FRAMES if quick else SYNTHETIC_FRAMES)
    families = [family for family in FAMILIES if family not in EMPTY_FAMILIES]
    each = -(-wanted // len(families))
    return _spread(synthetic_sources(families, [SYNTHETIC_NOISE], frames=each, seed=seed), wanted)


def _spread(sources: list[FrameSource], frames: int | None) -> list[FrameSource]:
    if frames is None:
        return sources
    places = np.linspace(0, len(sources) - 1, min(frames, len(sources))).round().astype(int)
    return [sources[place] for place in places]


def _data_name(dataset: str, sources: Sequence[FrameSource], *, synthetic: bool) -> str:
    if not synthetic:
        return Path(dataset).resolve().name
    families = dict.fromkeys(source.group.partition("/")[0] for source in sources)
    return f"synthetic scenes ({', '.join(families)}), {SYNTHETIC_NOISE} noise"


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
