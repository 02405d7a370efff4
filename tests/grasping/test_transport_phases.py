"""Ways of a held object to the tray."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control.tasks import AxisAlignment
from eyehand.grasping import Tray, put_down, transport_phases
from eyehand.grasping.motion import MotionResult
from eyehand.grasping.pick_options import PickOptions
from eyehand.grasping.put_down import PutDown
from eyehand.grasping.tray_plan import FREE_GAP, HeldSize, TrayPlace

SIZE = HeldSize(0.03, 0.06, 0.05, 0.1)
HERE, HIGH = np.array([0.2, 0.1, 0.18]), np.array([0.5, -0.2, 0.25])


@pytest.mark.parametrize(
    ("stuck", "ways"),
    [
        (0, ["direct"]),
        (1, ["direct", "raise", "direct"]),
        (3, ["direct", "raise", "direct", "planned"]),
    ],
)
def test_stuck_object_is_raised_before_a_path_is_planned(stuck, ways, monkeypatch):
    """The block of the tray and its content stands beside the straight way."""
    seen = []

    def carry(_cell, _state, controller, *_):
        name, tasks = controller
        at = tasks[0].goal
        raised = name == "direct" and np.array_equal(at, [HERE[0], HERE[1], HIGH[2]])
        assert raised or np.array_equal(at, HIGH)
        seen.append("raise" if raised else name)
        return MotionResult("stuck" if len(seen) <= stuck else "reached", "")

    monkeypatch.setattr(transport_phases, "_carry", carry)
    cell: Any = SimpleNamespace(
        palm_pose=lambda: RigidTransform.from_translation(HERE),
        tray=SimpleNamespace(contains=lambda *_: False),
    )
    state: Any = SimpleNamespace(
        direct_carry=lambda _, tasks: ("direct", tasks),
        transit=lambda _, tasks, __: ("planned", tasks),
    )
    up = np.array([0.0, 0.0, 1.0])
    way: Any = AxisAlignment(up, up)
    place = TrayPlace(HIGH, 0.0, FREE_GAP)
    goal = PutDown(SIZE, place, way, np.zeros(3), HIGH, HIGH)
    assert transport_phases._carry_over_tray(cell, state, goal)
    assert seen == ways


@pytest.mark.parametrize(("gap", "slack"), [(0.0, 0.01), (0.015, 0.015), (FREE_GAP, FREE_GAP)])
def test_object_is_over_its_place_within_the_gap_to_the_content(gap, slack, monkeypatch):
    """An arm without touch pressed a box with 220 N on a can 3 mm beside its place."""
    slacks = []

    def carry(_cell, _state, _controller, _seconds, _tasks, slack):
        slacks.append(slack)
        return MotionResult("reached", "")

    monkeypatch.setattr(transport_phases, "_carry", carry)
    place = TrayPlace(HIGH, 0.0, gap)
    up = np.array([0.0, 0.0, 1.0])
    goal = PutDown(SIZE, place, AxisAlignment(up, up), np.zeros(3), HIGH, HIGH)
    state: Any = SimpleNamespace(direct_carry=lambda *_: None)
    cell: Any = SimpleNamespace(
        palm_pose=lambda: RigidTransform.from_translation(HERE),
        tray=SimpleNamespace(contains=lambda *_: True),
    )
    assert transport_phases._carry_over_tray(cell, state, goal)
    assert slacks == [slack]


@pytest.mark.parametrize(("lifted", "high"), [(0.05, 0.142), (0.2, 0.2)])
def test_object_does_not_go_down_on_its_way_over_the_tray(lifted, high):
    """The hidden end of a flashlight hung below the end that was seen, and hit something."""
    up = np.array([0.0, 0.0, 1.0])
    cell: Any = SimpleNamespace(
        palm_pose=lambda: RigidTransform.from_translation([0.2, 0.1, lifted]),
        robot=SimpleNamespace(hand=None),
        tray=Tray(np.array([0.4, -0.2, 0.01]), (0.25, 0.36), 0.07),
        tray_content=(),
        tray_height=0.07,
        options=PickOptions(drop_height=0.012),
    )
    size = HeldSize(0.03, 0.06, 0.032, 0.05)
    goal = put_down._put_down(cell, size, AxisAlignment(up, up), np.zeros(3), 0.032)
    assert goal.low[2] == pytest.approx(0.01 + 0.012 + 0.032)
    assert goal.high[2] == pytest.approx(high)


def test_content_lies_where_it_was_released(monkeypatch):
    """A finger at the tray's wall kept a can 20 mm from its place."""
    up = np.array([0.0, 0.0, 1.0])
    planned, palm = HIGH, RigidTransform.from_translation(HIGH + np.array([0.02, 0.0, 0.0]))
    goal = PutDown(
        SIZE,
        TrayPlace(planned, 0.0, FREE_GAP),
        AxisAlignment(up, up),
        np.zeros(3),
        planned,
        planned,
    )
    monkeypatch.setattr(transport_phases, "put_down_poses", lambda *_: [goal])
    monkeypatch.setattr(transport_phases, "clear_poses", lambda *_: [goal])
    monkeypatch.setattr(
        transport_phases, "_carry_over_tray", lambda *_: MotionResult("reached", "")
    )
    monkeypatch.setattr(transport_phases, "_carry", lambda *_: MotionResult("stuck", ""))
    monkeypatch.setattr(transport_phases, "gripped_too_thin", lambda *_: "")
    monkeypatch.setattr(transport_phases, "shake_off", lambda *_: "")
    cell: Any = SimpleNamespace(
        palm_pose=lambda: palm,
        hand=SimpleNamespace(width=lambda _: 0.06, reach=lambda _: 0.1),
        reading=SimpleNamespace(hand=None),
        tray=SimpleNamespace(centre=np.zeros(3)),
        tray_content=(),
        tray_height=0.05,
    )
    state: Any = SimpleNamespace(
        held=None,
        plan=SimpleNamespace(opening=0.08),
        grasp=SimpleNamespace(target=SimpleNamespace(fit=None)),
        lower=lambda *_: None,
        release=lambda *_: None,
    )
    assert transport_phases.place(cell, state) is None
    (item,) = cell.tray_content
    np.testing.assert_allclose(item.place, palm.translation[:2])


@pytest.mark.parametrize(
    ("push", "lowering", "end"),
    [(20.0, True, "reached"), (20.0, False, "late"), (5.0, True, "late")],
)
def test_object_is_down_when_what_is_under_it_pushes_back(push, lowering, end, monkeypatch):
    """The hand pressed an object that was longer than its solid with 87 N on a finger."""

    def execute(_cell, _controller, _seconds, *, stop, **_):
        reason = stop(None)
        return MotionResult("stopped", reason) if reason else MotionResult("late", "")

    monkeypatch.setattr(transport_phases, "execute", execute)
    held = SimpleNamespace(pushed=push)
    state: Any = SimpleNamespace(lowering=lowering, held=held, lost=lambda _: "")
    cell: Any = SimpleNamespace(options=PickOptions())
    lower: Any = None
    assert transport_phases._carry(cell, state, lower, 2.5).end == end
