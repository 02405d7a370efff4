"""Ways of a held object to the tray."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control.tasks import AxisAlignment
from eyehand.grasping import transport_phases
from eyehand.grasping.motion import MotionResult
from eyehand.grasping.pick_options import PickOptions

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
    goal: Any = SimpleNamespace(high=HIGH, centre_in_palm=np.zeros(3), alignment=way)
    assert transport_phases._carry_over_tray(cell, state, goal)
    assert seen == ways


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
