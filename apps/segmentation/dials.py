"""The dials of `eyehand chart segmentation`: options that it varies, alone and in combination."""

from __future__ import annotations

from eyehand.perception import SegmentationOptions

from ..bench import DialBoard

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
