"""The dials of the segmentation: every one alone, the main ones crossed."""

from __future__ import annotations

from eyehand.perception import SegmentationOptions

from ..bench import DialBoard

STAGES = {"median": False, "shift_windows": False, "join_open": False}
STAGES |= {"join_occluded": False, "colour_edges": False}
"""Stages that are on by default, switched off."""

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
    # The stride makes the pixels few and so asks for other windows, threads gain on large images
    # only, and with every stage off the least time shows.
    crosses=(
        {"stride": (1, 2, 3, 4), "window": (5, 7, 9, 11, 13)},
        {"stride": (1, 2, 3, 4), "threads": (2,), "window": (7, 9, 11)},
        {"stride": (1, 2, 3, 4), "shift_windows": (False,), "window": (5, 9), "threads": (1, 2)},
        {
            "stride": (1, 2, 3, 4),
            "threads": (1, 2),
            **{stage: (off,) for stage, off in STAGES.items()},
        },
    ),
    quick={"stride": (1, 2, 4), "window": (5,), "threads": (2,), "shift_windows": (False,)},
    words={
        ("threads", 1): "1 thread",
        ("threads", 2): "2 threads",
        ("median", False): "no median",
        ("shift_windows", False): "no shift",
        ("join_open", False): "hollows apart",
        ("join_occluded", False): "occluded apart",
        ("colour_edges", False): "no colour",
        ("split_solids", True): "split solids",
        ("median", True): "median",
        ("shift_windows", True): "shift",
        ("join_open", True): "hollows joined",
        ("join_occluded", True): "occluded joined",
        ("colour_edges", True): "colour",
        ("split_solids", False): "solids whole",
    },
    bare=STAGES,
)
"""What the segmentation's chart turns."""
