"""Invalid inputs: each must be rejected in one line that says what is valid."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
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

from ..bench import Trial
from ..bench.stress_case import StressCase
from .stress_trial import lbr_world

NAN = float("nan")


def invalid_inputs() -> tuple[StressCase[ControlOptions], ...]:
    """Return all inputs that must be rejected."""
    world = lbr_world()
    home = world.robot.home
    goal = world.robot.at(home).position
    task = Position(goal)

    def step(q: object) -> Callable[[], object]:
        return lambda: ApproachController(world, [task]).step(_untyped(q))

    def position(value: object, **more: Any) -> Callable[[], object]:
        return lambda: Position(_untyped(value), **more)

    def options(**values: Any) -> Callable[[], object]:
        return lambda: ControlOptions(**values)

    def load(frame: str = TOOL_SITE, **more: Any) -> Callable[[], object]:
        return lambda: RobotModel.load(LBR_ARM, frame, **more)

    return (
        invalid("q with NaN", ("finite", "nan"), step(np.full(7, NAN))),
        invalid("q with infinity", ("finite", "inf"), step(np.full(7, np.inf))),
        invalid("q of 6 joints", ("(7,)", "(6,)", "joint7"), step(home[:6])),
        invalid("q of two postures", ("(7,)", "(2, 7)"), step(np.stack([home, home]))),
        invalid("q of strings", ("q", "7 numbers"), step(["a"] * 7)),
        invalid("no tasks", ("at least one task",), lambda: ApproachController(world, [])),
        invalid("goal with NaN", ("goal", "finite"), position([0.5, NAN, 0.4])),
        invalid("goal of 2 numbers", ("goal", "(2,)"), position([0.5, 0.4])),
        invalid("gain of 0", ("gain", "> 0"), position(goal, gain=0.0)),
        invalid("negative speed", ("speed", "> 0"), position(goal, speed=-1.0)),
        invalid("unknown frame", ("'hand'", TOOL_SITE, "link7"), load("hand")),
        invalid("unknown joint", ("'wrist'", "joint1"), load(joints=["wrist"])),
        invalid("home beyond a limit", ("home", "joint1"), load(home=np.full(7, 9.0))),
        invalid("joint speed of 0", ("speed", "> 0"), load(speed=0.0)),
        invalid(
            "missing robot file", ("nowhere.xml",), lambda: RobotModel.load("nowhere.xml", "t")
        ),
        invalid("box without size", ("half_extents", "0.0"), lambda: Box(np.zeros(3))),
        invalid("ball of radius 0", ("radius", "0.0"), lambda: Sphere(0.0)),
        invalid("negative radius", ("radius", "-0.1"), lambda: Sphere(-0.1)),
        invalid("flat mesh", ("plane",), lambda: ConvexMesh(_flat_points())),
        invalid(
            "obstacle without name", ("name",), lambda: Obstacle("", Sphere(0.1), _free_pose())
        ),
        invalid("duplicate name", ("'a'", "taken"), _duplicate_name),
        invalid(
            "unknown obstacle", ("'b'", "a"), lambda: _world_with_ball().move("b", _free_pose())
        ),
        invalid(
            "velocity of 3",
            ("velocity", "6"),
            lambda: _world_with_ball().move("a", _free_pose(), [1, 2, 3]),
        ),
        invalid("β as a string", ("beta", '"dynamic"'), options(beta="strong")),
        invalid("negative β", ("beta", "-1"), options(beta=-1.0)),
        invalid("period of 0", ("dt", "0"), options(dt=0.0)),
        invalid("period NaN", ("dt", "nan"), options(dt=NAN)),
        invalid("negative margin", ("margin", "-0.01"), options(margin=-0.01)),
    )


def invalid(
    name: str, expected: tuple[str, ...], action: Callable[[], object]
) -> StressCase[ControlOptions]:
    """Return the case of an action that must raise InputError with all expected texts."""

    def attempt(_seed: int, _options: ControlOptions) -> Trial:
        try:
            action()
        except InputError as error:
            message = " ".join(str(error).split())
            missing = [text for text in expected if text not in message]
            note = f"does not mention {missing}: {message}" if missing else message
            return Trial(not missing, note, refused=True)
        return Trial(False, "accepted")

    return StressCase(name, "refuse", attempt, ", ".join(expected))


def _world_with_ball() -> CollisionWorld:
    return lbr_world([Obstacle("a", Sphere(0.1), _free_pose())])


def _duplicate_name() -> None:
    _world_with_ball().add(Obstacle("a", Sphere(0.1), _free_pose()))


def _free_pose() -> RigidTransform:
    return RigidTransform.from_translation([2.0, 0.0, 0.0])


def _flat_points() -> np.ndarray:
    return np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


def _untyped(value: object) -> Any:
    """Return the value without its type, as a caller without a type checker passes it."""
    return value
