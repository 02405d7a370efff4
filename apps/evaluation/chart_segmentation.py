"""`eyehand chart segmentation`: its dials, time against accuracy, beside other methods."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.table import Table

from eyehand.apps.console import print_json, say, show, tracked
from eyehand.apps.description import ready_kernels
from eyehand.apps.description_files import make_folder
from eyehand.errors import InputError
from eyehand.perception import segment
from eyehand.perception.atomic_write import atomic_write
from eyehand.perception.segmentation.budget import FORMAT, STORED_FRONT, FrontPoint
from eyehand.perception.stored_front import StoredFront

from .chart_style import Provenance, write_chart
from .contest import Contestant
from .evaluate_segmentation import SYNTHETIC
from .machine import machine_line
from .pareto import simplest_front
from .pareto_chart import ChartPoint, PeerCurve, pareto_chart
from .segmentation_contest import Result, run_contest
from .segmentation_dataset import Coding, DatasetOptions, FrameSource, open_dataset
from .segmentation_dials import DialSetting, dial_settings
from .segmentation_peers import PEERS, Peer
from .synthetic_frames import EMPTY, FAMILIES, synthetic_sources

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, SegmentationOptions

OWN = "eyehand"
"""Whose settings are charted."""
SYNTHETIC_FRAMES = 20
"""Synthetic frames when no number is asked for."""
SYNTHETIC_NOISE = "realistic"
QUICK_FRAMES = 2
ROUNDS, QUICK_ROUNDS = 3, 1
"""How often each frame is segmented at each setting; the fastest time counts."""
SAME_TIME = 1.05
"""Factor by which the same setting's times differ between runs on a busy machine."""
SAME_F_PCT = 0.15
"""Difference of mean overlap F that says nothing: its standard error over 45 real frames."""
CHART_FILE = "segmentation.png"
STORED_SIZE = (480, 640)
"""Rows and columns of the frames for which the front is stored, px."""


def chart_segmentation(
    *,
    dataset: str = SYNTHETIC,
    labels: Coding = "plain",
    camera: Path | None = None,
    depth_scale_mm: float | None = None,
    seed: int = 0,
    frames: int | None = None,
    quick: bool = False,
    peers: bool = True,
    store: bool = False,
    out: Path = Path("out/chart_segmentation"),
    json: bool = False,
) -> int:
    """Chart time against accuracy of the segmentation over its dials, beside other methods.

    Prints a table; writes segmentation.png and the figures behind it, segmentation.csv.

    Parameters
    ----------
    dataset
        Folder of labelled frames as for eyehand evaluate segmentation, or the word synthetic.
    labels
        Coding of the labels in .npz files: plain numbers, or osd.
    camera
        Camera file of the frames; default: what the files, or a camera file beside them, say.
    depth_scale_mm
        Millimetres per unit of whole-number depth in .npz files; default: what the files say.
    seed
        First seed of synthetic scenes.
    frames
        Frames, spread evenly over the data set; default: all of a folder, 20 synthetic ones.
    quick
        Few settings, one of each peer, 2 frames: seconds in place of minutes, for a first look.
    peers
        Chart other methods too.
    store
        Keep the front for SegmentationOptions.for_budget.
    out
        Output folder.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if frames is not None and frames < 1:
        raise InputError(f"--frames must be >= 1, got {frames}")
    if store and quick:
        raise InputError("--store needs all settings: leave --quick out")
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
    ready_kernels()
    settings = dial_settings(quick=quick)
    rivals = PEERS if peers else ()
    contestants = [_own(setting) for setting in settings] + [
        contestant for peer in rivals for contestant in _rival(peer, quick=quick)
    ]
    results = run_contest(
        contestants,
        tracked(sources, "segmenting", len(sources)),
        QUICK_ROUNDS if quick else ROUNDS,
    )
    own, others = results[: len(settings)], results[len(settings) :]
    front = _front(own)
    data = _data_name(dataset, sources, synthetic=synthetic)
    made = Provenance(data, seed if synthetic else None, len(sources))
    rows = [
        _row(result, setting, index in front)
        for index, (result, setting) in enumerate(zip(own, settings, strict=True))
    ] + [_row(result, None, False) for result in others]
    write_chart(_figure(own, front, others, made), out / CHART_FILE, rows)
    show(_table(own, front, others), json_wanted=json)
    say(f"chart: {out / CHART_FILE}, figures: {(out / CHART_FILE).with_suffix('.csv')}")
    if store:
        store_front(settings, own, made)
    slower = _slower(own[0])
    if slower is not None:
        say(
            f"here, on these frames, the default takes {slower:.2f} times as long as in the stored "
            f"front: SegmentationOptions.for_budget(ms, slower={slower:.2f})"
        )
    if json:
        print_json(
            "chart_segmentation",
            made.seed,
            rows,
            dataset=dataset,
            frames=made.frames,
            machine=machine_line(),
            slower=slower,
            out=str(out),
        )
    return 0


def store_front(settings: Sequence[DialSetting], own: Sequence[Result], made: Provenance) -> None:
    """Write the front of the own results, the default first among them, for time budgets.

    Raises
    ------
    InputError
        If the installed package cannot be written to.
    """
    front = _front(own)
    points = tuple(
        FrontPoint(
            settings[index].name,
            settings[index].all_dials(),
            own[index].median_ms,
            own[index].overlap_f_pct,
            own[index].boundary_f_pct,
            own[index].found_pct,
        )
        for index in front
    )
    stored = StoredFront(
        points, own[0].median_ms, made.data, made.seed, made.frames, machine_line()
    )
    with atomic_write(STORED_FRONT) as temporary:
        temporary.write_text(FORMAT.text(stored), encoding="utf-8")
    say(f"stored {len(points)} settings for SegmentationOptions.for_budget")


def _synthetic(frames: int | None, seed: int, *, quick: bool) -> list[FrameSource]:
    wanted = frames or (QUICK_FRAMES if quick else SYNTHETIC_FRAMES)
    families = [family for family in FAMILIES if family != EMPTY]
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


def _own(setting: DialSetting) -> Contestant:
    return Contestant(OWN, setting.name, partial(_labels, options=setting.options))


def _labels(frame: DepthFrame, *, options: SegmentationOptions) -> NDArray[np.int32]:
    return segment(frame, options).labels


def _rival(peer: Peer, *, quick: bool) -> list[Contestant]:
    values = peer.settings[len(peer.settings) // 2 :][:1] if quick else peer.settings
    return [
        Contestant(peer.name, f"{peer.dial} {value:g}", partial(_run_peer, peer, value))
        for value in values
    ]


def _run_peer(peer: Peer, value: float, frame: DepthFrame) -> NDArray[np.int32]:
    return peer.run(frame, value)


def _row(result: Result, setting: DialSetting | None, on_front: bool) -> dict[str, Any]:
    row = {
        "method": result.contestant.method,
        "name": result.contestant.name,
        "default": setting is not None and not setting.dials,
        "front": on_front,
        "median_ms": result.median_ms,
        "median_cpu_ms": result.median_cpu_ms,
        "overlap_f_pct": result.overlap_f_pct,
        "boundary_f_pct": result.boundary_f_pct,
        "found_pct": result.found_pct,
    }
    return row if setting is None else row | setting.all_dials()


def _front(own: Sequence[Result]) -> list[int]:
    times = [result.median_ms for result in own]
    return simplest_front(times, [r.overlap_f_pct for r in own], SAME_TIME, SAME_F_PCT)


def _figure(
    own: Sequence[Result], front: Sequence[int], others: Sequence[Result], made: Provenance
) -> Figure:
    points = [_point(result) for result in own]
    names = dict.fromkeys(result.contestant.method for result in others)
    curves = [
        PeerCurve(name, tuple(_point(r) for r in others if r.contestant.method == name))
        for name in names
    ]
    subtitle = "blue: every dial, alone and crossed; line: the best for its time, beyond chance"
    if curves:
        subtitle += "; grey: other methods"
    return pareto_chart(
        "Segmentation: time against accuracy",
        subtitle,
        points,
        front,
        0,
        curves,
        "overlap F",
        made,
    )


def _point(result: Result) -> ChartPoint:
    return ChartPoint(result.contestant.name, result.median_ms, result.overlap_f_pct)


def _table(own: Sequence[Result], front: Sequence[int], others: Sequence[Result]) -> Table:
    """Tabulate the front, the default, and each peer at its best."""
    table = Table(
        title="the Pareto front, the default, and each peer at its best",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        caption="F, bF: mean overlap and boundary F; %75: objects with F > 75 %; all in %",
        caption_justify="left",
    )
    for name in ("method", "setting", "ms", "F", "bF", "%75"):
        table.add_column(name, justify="left" if name in ("method", "setting") else "right")
    shown = sorted({0, *front}, key=lambda index: own[index].median_ms)
    for index in shown:
        table.add_row(*_cells(own[index]), style=None if index in front else "dim")
    table.add_section()
    for method in dict.fromkeys(result.contestant.method for result in others):
        curve = [result for result in others if result.contestant.method == method]
        table.add_row(*_cells(max(curve, key=lambda result: result.overlap_f_pct)))
    return table


def _cells(result: Result) -> tuple[str, ...]:
    figures = (result.overlap_f_pct, result.boundary_f_pct, result.found_pct)
    return (
        result.contestant.method,
        result.contestant.name,
        f"{result.median_ms:.1f}",
        *(f"{figure:.1f}" for figure in figures),
    )


def _slower(default: Result) -> float | None:
    """How many times longer the default takes here than for the stored front."""
    if not STORED_FRONT.is_file():
        return None
    return round(default.median_ms / FORMAT.read(STORED_FRONT).default_ms, 3)
