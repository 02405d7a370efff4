"""Objects without a pick are listed once each, with the reason of the robot."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from eyehand.apps.grasp.bench.unattempted import unattempted_objects
from eyehand.grasping import ClearReport

PLACES = {"can": 0.0, "plate": 1.0, "ball": 2.0}


def outcomes(
    left: list[str],
    tried: list[str],
    remaining: tuple[str, ...],
    stopped: str,
    fault: str = "",
    last: str = "placed",
) -> list[tuple[str, str]]:
    """Return names and outcomes. The robot perceives objects 1, 2, ... at the true positions."""
    perceived = [
        SimpleNamespace(label=label, points=np.full((4, 3), at))
        for label, at in enumerate(PLACES.values(), start=1)
    ]
    cell = SimpleNamespace(
        scene=SimpleNamespace(objects=perceived), reading=SimpleNamespace(fault=fault)
    )
    report = ClearReport(cast("Any", (SimpleNamespace(outcome=last),)), 1, remaining, stopped)

    def nearest(point: np.ndarray) -> str:
        return min(PLACES, key=lambda name: abs(PLACES[name] - point[0]))

    rows = unattempted_objects(left, tried, report, cast("Any", cell), nearest)
    return [(row.object, row.outcome) for row in rows]


NOTHING = "no remaining object can be grasped"


@pytest.mark.parametrize(
    ("left", "tried", "remaining", "stopped", "rows"),
    [
        ([], ["can"], (), "clear", []),
        (["can"], [], ("object 1: wider than the hand",), NOTHING, [("can", "refused")]),
        (
            ["can"],
            [],
            ("object 1: the arm cannot reach a pincer: stuck",),
            NOTHING,
            [("can", "unreachable")],
        ),
        (["can"], ["can"], ("object 1: skipped after 2 attempts",), NOTHING, []),
        (
            ["can", "plate"],
            ["can"],
            ("object 1: skipped after 2 attempts", "object 2: too flat"),
            NOTHING,
            [("plate", "refused")],
        ),
        (["ball"], [], ("object 1: too flat",), NOTHING, [("ball", "unseen")]),
        (["plate"], ["can"], (), "clear", [("plate", "unseen")]),
        (["can", "plate"], [], (), "the table is not where it was", [("", "doubt")]),
        (["can"], ["can"], (), "the table is not where it was", []),
        (
            ["can", "plate"],
            ["can"],
            ("object 1: not tried", "object 2: not tried"),
            "2 picks failed in a row",
            [],
        ),
    ],
)
def test_unattempted_object_is_listed_once(left, tried, remaining, stopped, rows):
    assert outcomes(left, tried, remaining, stopped) == rows


def test_robot_fault_is_listed_once():
    remaining = ("object 1: not tried",)
    assert outcomes(["can"], [], remaining, "drive 3", fault="drive 3") == [("", "fault")]
    assert outcomes(["can"], [], remaining, "drive 3", fault="drive 3", last="fault") == []
