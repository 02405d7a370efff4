"""Poses in which a held object is released in the tray."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control.tasks import AxisAlignment, Orientation
from eyehand.grasping import Tray, load_hand, put_down, transport_phases
from eyehand.grasping.hands.jaw_control import JawControl
from eyehand.grasping.motion import MotionResult
from eyehand.grasping.put_down import MAX_RAISE, PutDown, clear_poses
from eyehand.grasping.tray_clearance import (
    clear_heights,
    lowest_points,
    opening_boxes,
    tray_columns,
)
from eyehand.grasping.tray_plan import FREE_GAP, UP, HeldSize, TrayItem, TrayPlace
from eyehand.perception import Superquadric

TRAY = Tray(np.array([0.4, -0.1, 0.01]), (0.3, 0.3), 0.06)
SIZE = HeldSize(0.02, 0.04, 0.03, 0.06)
GRIPPER = load_hand("panda")
DOWN = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))
LOW = TRAY.centre + np.array([0.0, 0.0, 0.042])
GOAL = PutDown(
    SIZE,
    TrayPlace(TRAY.centre, 0.0, FREE_GAP),
    AxisAlignment(-UP, UP),
    np.zeros(3),
    LOW,
    LOW + 0.2 * UP,
)


def upright_size(low_points, feels=False, solid=True):
    """Return the size of a neck, 160 to 200 mm above the table, with another segment."""
    pose = RigidTransform.from_translation([0.0, 0.0, 0.18])
    neck = Superquadric(np.array([0.012, 0.012, 0.02]), (0.1, 1.0), pose, "cylinder")
    ends = np.array([[-0.012, 0.0, 0.16], [0.012, 0.0, 0.2]])
    fit = SimpleNamespace(superquadric=neck if solid else None, parts=())
    target = SimpleNamespace(label=1, points=ends, fit=fit)
    other = SimpleNamespace(label=2, points=np.array(low_points, float).reshape(-1, 3))
    support = SimpleNamespace(normal=UP, offset=0.0)
    scene = SimpleNamespace(support=support, objects=[target, other])
    state: Any = SimpleNamespace(
        grasp=SimpleNamespace(scene=scene, target=target), held=object() if feels else None
    )
    return put_down._upright_size(state, put_down.object_centre(state))


BODY = [[0.01, 0.0, 0.15], [0.03, 0.0, 0.05]]


@pytest.mark.parametrize(
    ("low_points", "feels", "radius", "below"),
    [
        ([], False, 0.012, 0.18),
        ([[0.1, 0.0, 0.05]], False, 0.012, 0.18),
        (BODY, False, 0.03, 0.18),
        (BODY, True, 0.012, 0.02),
    ],
)
def test_object_reaches_down_to_the_table_with_what_is_under_it(low_points, feels, radius, below):
    """The solid of a bottle was its neck, and an arm pressed the rest 156 mm below the floor."""
    size = upright_size(low_points, feels)
    assert (size.radius, size.below) == pytest.approx((radius, below), abs=1e-3)
    assert size.height == pytest.approx(below + 0.02, abs=1e-3)


def test_object_without_solid_has_the_size_of_its_readings():
    size = upright_size([], solid=False)
    assert (size.radius, size.below, size.height) == pytest.approx((0.012, 0.18, 0.2))


def poses(monkeypatch, content, reachable=lambda *_: True):
    """Return the poses in which a gripper that points down releases a box."""
    monkeypatch.setattr(put_down, "is_reachable", reachable)
    cell: Any = SimpleNamespace(
        palm_pose=lambda: RigidTransform.from_components(LOW, DOWN),
        hand=JawControl(GRIPPER),
        robot=SimpleNamespace(hand=GRIPPER),
        reading=SimpleNamespace(hand=SimpleNamespace(width=0.04), q=np.zeros(7)),
        tray=TRAY,
        tray_content=content,
    )
    monkeypatch.setattr(JawControl, "width", lambda *_: 0.04)
    state: Any = SimpleNamespace(
        prototype="precision", world=lambda *_: None, near_options=lambda _: None
    )
    return list(clear_poses(cell, state, GOAL))


def item(x, y, top=0.15, radius=0.03):
    """Return an object that stands in the tray at a distance from its centre."""
    return TrayItem(TRAY.centre[:2] + np.array([x, y]), radius, top)


def test_hand_that_clears_everything_is_not_turned(monkeypatch):
    assert poses(monkeypatch, [item(-0.1, -0.1)])[0] is GOAL


def test_hand_turns_so_that_its_jaws_open_beside_what_stands_there(monkeypatch):
    content = [item(0.062, 0.0), item(-0.062, 0.0), item(0.1, 0.1)]
    first = poses(monkeypatch, content)[0]
    assert isinstance(first.alignment, Orientation)
    assert first.low[2] == pytest.approx(LOW[2], abs=0.005)
    turned: Any = first.alignment.goal
    axes = turned.as_matrix()
    np.testing.assert_allclose(axes[:, 2], -UP, atol=1e-9)
    points = lowest_points(opening_boxes(GRIPPER, "precision", 0.04), axes, np.zeros(3))
    clear = clear_heights(tray_columns(TRAY, content), points, first.low[None, :2])[0]
    assert clear <= first.low[2] - TRAY.centre[2] + 1e-9


@pytest.mark.parametrize(("top", "count"), [(0.1, 1), (0.2, 0)])
def test_object_is_not_released_far_above_its_usual_height(monkeypatch, top, count):
    """The arm reaches no other pose."""
    found = poses(monkeypatch, [item(0.062, 0.0, top)], lambda *_: False)
    assert len(found) == count
    for pose in found:
        assert LOW[2] + 0.05 < pose.low[2] < LOW[2] + MAX_RAISE


def lowered(monkeypatch, *stuck_above):
    """Place an object where lowering is stuck this far above its goals; return the failure."""
    high = GOAL.high
    at, seen = [high], []
    left = list(stuck_above)

    def carry(_cell, _state, controller, *_):
        seen.append(controller)
        if controller != "lower":
            at[0] = high
            return MotionResult("reached", "")
        rest = left.pop(0) if left else 0.0
        at[0] = GOAL.low + rest * UP
        return MotionResult("stuck" if rest else "reached", "")

    for name in ("gripped_too_thin", "shake_off"):
        monkeypatch.setattr(transport_phases, name, lambda *_: "")
    monkeypatch.setattr(transport_phases, "_carry", carry)
    monkeypatch.setattr(transport_phases, "put_down_poses", lambda *_: [GOAL])
    monkeypatch.setattr(transport_phases, "clear_poses", lambda *_: [GOAL, PutDown(**vars(GOAL))])
    monkeypatch.setattr(transport_phases, "object_centre", lambda _: np.zeros(3))
    cell: Any = SimpleNamespace(
        palm_pose=lambda: RigidTransform.from_components(at[0], DOWN),
        hand=SimpleNamespace(width=lambda _: 0.04, reach=lambda _: 0.1),
        reading=SimpleNamespace(hand=None),
        tray=TRAY,
        tray_content=(),
        tray_height=0.05,
        options=SimpleNamespace(drop_height=0.012),
    )
    state: Any = SimpleNamespace(
        held=None,
        lowering=False,
        plan=SimpleNamespace(opening=0.08),
        grasp=SimpleNamespace(target=SimpleNamespace(fit=None)),
        release=lambda *_: seen.append("release"),
        **{
            name: (lambda *_, name=name: name)
            for name in ("lower", "direct_carry", "move_off", "transit")
        },
    )
    return transport_phases.place(cell, state), seen, cell.tray_content


OVER = ["direct_carry"]


@pytest.mark.parametrize(
    ("above", "motions"),
    [
        ([0.04], ["lower", "release"]),
        ([0.06], ["lower", "move_off", "direct_carry", "lower", "release"]),
    ],
)
def test_object_that_ends_above_its_place_is_raised_and_put_elsewhere(monkeypatch, above, motions):
    failure, seen, content = lowered(monkeypatch, *above)
    assert failure is None
    assert seen == OVER + motions
    assert len(content) == 1


def test_object_without_a_free_place_is_put_back(monkeypatch):
    failure, seen, content = lowered(monkeypatch, 0.06, 0.08)
    assert failure is not None
    assert failure.outcome == "place_failed"
    assert "no free place" in failure.reason
    assert seen[-2:] == ["transit", "lower"]
    assert "release" not in seen
    assert not content
