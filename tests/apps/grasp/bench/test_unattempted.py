"""Objects without a pick are listed once each, with the reason of the robot."""

import itertools
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.grasp.bench.unattempted import too_wide_objects, unattempted_objects
from eyehand.data_synth.scenes import MeshObject
from eyehand.grasping import ClearReport

PLACES = {"can": 0.0, "plate": 1.0, "ball": 2.0}


def outcomes(
    left: list[str],
    tried: list[str],
    remaining: tuple[str, ...],
    stopped: str,
    fault: str = "",
    last: str = "placed",
    too_wide: tuple[str, ...] = (),
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

    rows = unattempted_objects(left, tried, report, cast("Any", cell), nearest, too_wide)
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


def test_refused_object_that_is_too_wide_is_named_so():
    left, remaining = ["can", "plate"], ("object 1: wider than the stroke", "object 2: too flat")
    assert outcomes(left, [], remaining, NOTHING, too_wide=("can",)) == [
        ("can", "too_wide"),
        ("plate", "refused"),
    ]


def test_objects_wider_than_the_stroke_in_all_directions_are_too_wide():
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))

    def item(name: str, half: tuple[float, float, float], pieces: tuple = ()) -> MeshObject:
        points = corners * half
        faces = ConvexHull(points).simplices.astype(np.int64)
        pose = RigidTransform.from_rotation(Rotation.from_euler("xyz", [0.3, 0.5, 0.7]))
        return MeshObject(name, points, faces, 0.1, (1, 1, 1), pose, pieces)

    walls = [np.array([s * 0.045, 0, 0]) + corners * [0.003, 0.045, 0.045] for s in (-1, 1)]
    items = [
        item("cube", (0.044, 0.044, 0.044)),
        item("board", (0.2, 0.2, 0.03)),
        item("hollow", (0.048, 0.045, 0.045), tuple(walls)),
    ]
    assert too_wide_objects(items, 0.08) == {"cube": pytest.approx(0.088)}
    assert not too_wide_objects(items, 0.085), "its ends may be narrower"
