"""Invalid inputs of the control basis: each is rejected in one line that says what is valid."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.control import (
    ApproachController,
    Box,
    CollisionWorld,
    ControlOptions,
    ConvexMesh,
    Obstacle,
    RobotModel,
    Sphere,
)
from eyehand.control.tasks import Position
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.errors import InputError

NAN = float("nan")
AWAY = RigidTransform.from_translation([2.0, 0.0, 0.0])
BALL = Obstacle("a", Sphere(0.1), AWAY)
FLAT = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
ROBOT = RobotModel.load(LBR_ARM, TOOL_SITE)
HOME = ROBOT.home
GOAL = ROBOT.at(HOME).position


def world() -> CollisionWorld:
    return CollisionWorld(ROBOT, [BALL])


def step(q: Any) -> object:
    return ApproachController(world(), [Position(GOAL)]).step(q)


def load(frame: str = TOOL_SITE, **more: Any) -> object:
    return RobotModel.load(LBR_ARM, frame, **more)


def position(value: Any, **more: Any) -> object:
    return Position(value, **more)


def options(**values: Any) -> object:
    return ControlOptions(**values)


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (lambda: step(np.full(7, NAN)), ("finite", "nan")),
        (lambda: step(np.full(7, np.inf)), ("finite", "inf")),
        (lambda: step(HOME[:6]), ("(7,)", "(6,)", "joint7")),
        (lambda: step(np.stack([HOME, HOME])), ("(7,)", "(2, 7)")),
        (lambda: step(["a"] * 7), ("q", "7 numbers")),
        (lambda: ApproachController(world(), []), ("at least one task",)),
        (lambda: position([0.5, NAN, 0.4]), ("goal", "finite")),
        (lambda: position([0.5, 0.4]), ("goal", "(2,)")),
        (lambda: position(GOAL, gain=0.0), ("gain", "> 0")),
        (lambda: position(GOAL, speed=-1.0), ("speed", "> 0")),
        (lambda: load("hand"), ("'hand'", TOOL_SITE, "link7")),
        (lambda: load(joints=["wrist"]), ("'wrist'", "joint1")),
        (lambda: load(home=np.full(7, 9.0)), ("home", "joint1")),
        (lambda: load(speed=0.0), ("speed", "> 0")),
        (lambda: RobotModel.load("nowhere.xml", "t"), ("nowhere.xml",)),
        (lambda: Box(np.zeros(3)), ("half_extents", "0.0")),
        (lambda: Sphere(0.0), ("radius", "0.0")),
        (lambda: Sphere(-0.1), ("radius", "-0.1")),
        (lambda: ConvexMesh(FLAT), ("plane",)),
        (lambda: Obstacle("", Sphere(0.1), AWAY), ("name",)),
        (lambda: world().add(BALL), ("'a'", "taken")),
        (lambda: world().move("b", AWAY), ("'b'", "a")),
        (lambda: world().move("a", AWAY, [1, 2, 3]), ("velocity", "6")),
        (lambda: options(beta="strong"), ("beta", '"dynamic"')),
        (lambda: options(beta=-1.0), ("beta", "-1")),
        (lambda: options(dt=0.0), ("dt", "0")),
        (lambda: options(dt=NAN), ("dt", "nan")),
        (lambda: options(margin=-0.01), ("margin", "-0.01")),
    ],
)
def test_invalid_input_is_rejected_with_a_message(
    action: Callable[[], object], words: tuple[str, ...]
):
    with pytest.raises(InputError) as error_info:
        action()
    message = str(error_info.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []
