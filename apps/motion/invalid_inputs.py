"""Invalid inputs: each must be rejected in one line that says what is valid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table
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

from .stress_trial import lbr_world

if TYPE_CHECKING:
    from collections.abc import Sequence

NAN = float("nan")


@dataclass(frozen=True)
class InvalidInput:
    """An invalid input."""

    name: str
    """Description of the input."""
    expected: tuple[str, ...]
    """Texts that the message must contain: the value, or valid names."""
    attempt: Callable[[], object]
    """Pass the input to the product."""


@dataclass(frozen=True)
class Rejection:
    """The result of an invalid input."""

    input: InvalidInput
    rejected: bool
    """Whether it was rejected with the expected message."""
    result: str
    """The message, or what happened instead."""


def invalid_inputs() -> tuple[InvalidInput, ...]:
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
        InvalidInput("q with NaN", ("finite", "nan"), step(np.full(7, NAN))),
        InvalidInput("q with infinity", ("finite", "inf"), step(np.full(7, np.inf))),
        InvalidInput("q of 6 joints", ("(7,)", "(6,)", "joint7"), step(home[:6])),
        InvalidInput("q of two postures", ("(7,)", "(2, 7)"), step(np.stack([home, home]))),
        InvalidInput("q of strings", ("q", "7 numbers"), step(["a"] * 7)),
        InvalidInput("no tasks", ("at least one task",), lambda: ApproachController(world, [])),
        InvalidInput("goal with NaN", ("goal", "finite"), position([0.5, NAN, 0.4])),
        InvalidInput("goal of 2 numbers", ("goal", "(2,)"), position([0.5, 0.4])),
        InvalidInput("gain of 0", ("gain", "> 0"), position(goal, gain=0.0)),
        InvalidInput("negative speed", ("speed", "> 0"), position(goal, speed=-1.0)),
        InvalidInput("unknown frame", ("'hand'", TOOL_SITE, "link7"), load("hand")),
        InvalidInput("unknown joint", ("'wrist'", "joint1"), load(joints=["wrist"])),
        InvalidInput("home beyond a limit", ("home", "joint1"), load(home=np.full(7, 9.0))),
        InvalidInput("joint speed of 0", ("speed", "> 0"), load(speed=0.0)),
        InvalidInput(
            "missing robot file", ("nowhere.xml",), lambda: RobotModel.load("nowhere.xml", "t")
        ),
        InvalidInput("box without size", ("half_extents", "0.0"), lambda: Box(np.zeros(3))),
        InvalidInput("ball of radius 0", ("radius", "0.0"), lambda: Sphere(0.0)),
        InvalidInput("negative radius", ("radius", "-0.1"), lambda: Sphere(-0.1)),
        InvalidInput("flat mesh", ("plane",), lambda: ConvexMesh(_flat_points())),
        InvalidInput(
            "obstacle without name", ("name",), lambda: Obstacle("", Sphere(0.1), _free_pose())
        ),
        InvalidInput("duplicate name", ("'a'", "taken"), _duplicate_name),
        InvalidInput(
            "unknown obstacle", ("'b'", "a"), lambda: _world_with_ball().move("b", _free_pose())
        ),
        InvalidInput(
            "velocity of 3",
            ("velocity", "6"),
            lambda: _world_with_ball().move("a", _free_pose(), [1, 2, 3]),
        ),
        InvalidInput("β as a string", ("beta", '"dynamic"'), options(beta="strong")),
        InvalidInput("negative β", ("beta", "-1"), options(beta=-1.0)),
        InvalidInput("period of 0", ("dt", "0"), options(dt=0.0)),
        InvalidInput("period NaN", ("dt", "nan"), options(dt=NAN)),
        InvalidInput("negative margin", ("margin", "-0.01"), options(margin=-0.01)),
    )


def try_input(invalid: InvalidInput) -> Rejection:
    """Pass an invalid input, and check that it is rejected with the expected message."""
    try:
        invalid.attempt()
    except InputError as error:
        message = " ".join(str(error).split())
        missing = [text for text in invalid.expected if text not in message]
        result = f"does not mention {missing}: {message}" if missing else message
        return Rejection(invalid, not missing, result)
    # Any other exception would reach the user as a traceback.
    except Exception as error:
        return Rejection(invalid, False, f"raised {type(error).__name__}: {error}")
    return Rejection(invalid, False, "accepted")


def rejection_rows(rejections: Sequence[Rejection]) -> list[dict[str, Any]]:
    """Return one row per input, for JSON."""
    return [
        {"name": one.input.name, "kept": one.rejected, "happened": one.result} for one in rejections
    ]


def rejection_table(rejections: Sequence[Rejection]) -> Table:
    """Return the table for the terminal. Inputs that were not rejected are red."""
    table = Table(title="invalid input", title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("input", "rejected", "message"):
        table.add_column(column, no_wrap=column != "message")
    for one in rejections:
        style = None if one.rejected else "bold red"
        # Brackets in messages are not markup.
        table.add_row(
            one.input.name, "yes" if one.rejected else "NO", escape(one.result), style=style
        )
    return table


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
