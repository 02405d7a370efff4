"""Weighing a grasped object above its support, and grasping deeper if it slides out."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.grasping import grasp_phases, weighing
from eyehand.grasping.motion import MotionResult
from eyehand.grasping.pick_options import PickOptions
from eyehand.grasping.pick_state import PhaseFailure

STUCK = PhaseFailure("stuck", "at the grasp")


@pytest.mark.parametrize(
    ("pushes", "deeper", "again", "outcome"),
    [
        ([0.2], None, False, None),
        ([3.7, 0.0], None, True, None),
        ([3.7, 2.0], None, True, "slipped"),
        ([3.7], STUCK, True, "stuck"),
    ],
)
def test_object_that_is_pressed_down_is_grasped_deeper_once(
    pushes, deeper, again, outcome, monkeypatch
):
    """A bottle whose lower half was not seen slid out of fingertips above its middle."""
    left, grasped = list(pushes), []
    state: Any = SimpleNamespace(held=None)

    def weigh_once(_cell, state):
        state.held = SimpleNamespace(pushed=left.pop(0))

    def grasp_deeper(_cell, _state):
        grasped.append(True)
        return deeper

    monkeypatch.setattr(weighing, "_weigh_once", weigh_once)
    monkeypatch.setattr(weighing, "grasp_deeper", grasp_deeper)
    cell: Any = None
    failure = weighing.weigh(cell, state)
    assert (failure.outcome if failure else None) == outcome
    assert bool(grasped) == again
    assert not left


def test_rise_ends_when_the_raised_hand_still_presses(monkeypatch):
    """A hand that has just begun to rise may still press on the object."""
    heights, pushes = iter([0.002, 0.003, 0.005]), []

    def execute(_cell, _controller, _seconds, *, stop, **_):
        while not (end := stop(None)):
            pushes.append(end)
        return MotionResult("stopped", end)

    monkeypatch.setattr(weighing, "execute", execute)
    state: Any = SimpleNamespace(
        held=SimpleNamespace(pushed=5.0, steady=True),
        T_palm_world_at_grasp=RigidTransform.identity(),
        move_off=lambda *_: None,
        lost=lambda _: "",
    )
    cell: Any = SimpleNamespace(
        palm_pose=lambda: RigidTransform.from_translation([0.0, 0.0, next(heights)]),
        options=PickOptions(),
    )
    # Nothing is weighed, and the friction is not measured.
    assert weighing._weigh_once(cell, state) is None
    assert pushes == ["", ""]


def test_deeper_grasp_moves_the_open_hand_along_its_palm(monkeypatch):
    """The fingers open, go 10 mm further over the object, and close again."""
    steps = []
    for name in ("contact", "close", "grip"):
        monkeypatch.setattr(grasp_phases, name, lambda *_, name=name: steps.append(name))
    monkeypatch.setattr(grasp_phases, "execute", lambda *_, **__: steps.append("move"))
    monkeypatch.setattr(grasp_phases, "control_tasks", lambda *_: ())
    down = RigidTransform.from_components([0.1, 0.2, 0.3], Rotation.from_euler("x", np.pi))
    cell: Any = SimpleNamespace(
        palm_pose=lambda: down,
        hand=SimpleNamespace(preshape=lambda *_: "open"),
        wait=lambda _, command: steps.append(command),
        robot=SimpleNamespace(hand=None),
        options=PickOptions(),
    )
    state: Any = SimpleNamespace(
        offset=np.zeros(3),
        plan=SimpleNamespace(opening=0.08),
        prototype="precision",
        held="held",
        closing="closing",
        near=lambda *_: None,
    )
    assert grasp_phases.grasp_deeper(cell, state) is None
    assert steps == ["open", "move", "contact", "close", "grip"]
    assert state.held is None
    np.testing.assert_allclose(state.offset, [0.0, 0.0, -grasp_phases.DEEPER_STEP], atol=1e-12)
