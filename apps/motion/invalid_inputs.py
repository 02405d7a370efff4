"""Input that is wrong: each must be refused in one line that says what would be right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table
from scipy.spatial.transform import RigidTransform, Rotation

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
class WrongInput:
    """One wrong input."""

    name: str
    """What is wrong, in words."""
    says: tuple[str, ...]
    """What the refusal must hold: the value, or names that would be right."""
    attempt: Callable[[], object]
    """Hand it in."""


@dataclass(frozen=True)
class Refusal:
    """What came of it."""

    wrong: WrongInput
    kept: bool
    """Whether it was refused, as it should be."""
    happened: str
    """The message, or what came in its place."""


def wrong_inputs() -> tuple[WrongInput, ...]:
    """Everything that must be refused."""
    world = lbr_world()
    home = world.robot.home
    goal = world.robot.at(home).position
    task = Position(goal)

    def step(q: object) -> Callable[[], object]:
        return lambda: ApproachController(world, [task]).step(_any(q))

    def position(value: object, **more: Any) -> Callable[[], object]:
        return lambda: Position(_any(value), **more)

    def options(**values: Any) -> Callable[[], object]:
        return lambda: ControlOptions(**values)

    def load(frame: str = TOOL_SITE, **more: Any) -> Callable[[], object]:
        return lambda: RobotModel.load(LBR_ARM, frame, **more)

    return (
        WrongInput("q with NaN", ("finite", "nan"), step(np.full(7, NAN))),
        WrongInput("q with infinity", ("finite", "inf"), step(np.full(7, np.inf))),
        WrongInput("q of 6 joints", ("(7,)", "(6,)", "joint7"), step(home[:6])),
        WrongInput("q of two postures", ("(7,)", "(2, 7)"), step(np.stack([home, home]))),
        WrongInput("q of words", ("q", "7 numbers"), step(["a"] * 7)),
        WrongInput("no tasks", ("at least one task",), lambda: ApproachController(world, [])),
        WrongInput("goal with NaN", ("goal", "finite"), position([0.5, NAN, 0.4])),
        WrongInput("goal of 2 numbers", ("goal", "(2,)"), position([0.5, 0.4])),
        WrongInput("gain of 0", ("gain", "> 0"), position(goal, gain=0.0)),
        WrongInput("negative speed", ("speed", "> 0"), position(goal, speed=-1.0)),
        WrongInput("unknown frame", ("'hand'", TOOL_SITE, "link7"), load("hand")),
        WrongInput("unknown joint", ("'wrist'", "joint1"), load(joints=["wrist"])),
        WrongInput("home beyond a limit", ("home", "joint1"), load(home=np.full(7, 9.0))),
        WrongInput("joint speed of 0", ("speed", "> 0"), load(speed=0.0)),
        WrongInput("no robot file", ("nowhere.xml",), lambda: RobotModel.load("nowhere.xml", "t")),
        WrongInput("box without size", ("half_extents", "0.0"), lambda: Box(np.zeros(3))),
        WrongInput("ball of radius 0", ("radius", "0.0"), lambda: Sphere(0.0)),
        WrongInput("negative radius", ("radius", "-0.1"), lambda: Sphere(-0.1)),
        WrongInput("flat mesh", ("plane",), lambda: ConvexMesh(_square())),
        WrongInput("obstacle without name", ("name",), lambda: Obstacle("", Sphere(0.1), _here())),
        WrongInput("two of one name", ("'a'", "taken"), _twice),
        WrongInput("unknown obstacle", ("'b'", "a"), lambda: _one().move("b", _here())),
        WrongInput(
            "velocity of 3", ("velocity", "6"), lambda: _one().move("a", _here(), [1, 2, 3])
        ),
        WrongInput("β in words", ("beta", '"dynamic"'), options(beta="strong")),
        WrongInput("negative β", ("beta", "-1"), options(beta=-1.0)),
        WrongInput("period of 0", ("dt", "0"), options(dt=0.0)),
        WrongInput("period NaN", ("dt", "nan"), options(dt=NAN)),
        WrongInput("negative margin", ("margin", "-0.01"), options(margin=-0.01)),
    )


def refused(wrong: WrongInput) -> Refusal:
    """Hand a wrong input in and see whether it is refused with the right words."""
    try:
        wrong.attempt()
    except InputError as error:
        said = " ".join(str(error).split())
        missing = [word for word in wrong.says if word not in said]
        return Refusal(wrong, not missing, f"does not say {missing}: {said}" if missing else said)
    # Any other exception would be a traceback in somebody's program: that is what is looked for.
    except Exception as error:
        return Refusal(wrong, False, f"raised {type(error).__name__}: {error}")
    return Refusal(wrong, False, "accepted")


def refusal_rows(refusals: Sequence[Refusal]) -> list[dict[str, Any]]:
    """One row an input, for JSON."""
    return [
        {"name": one.wrong.name, "kept": one.kept, "happened": one.happened} for one in refusals
    ]


def refusal_table(refusals: Sequence[Refusal]) -> Table:
    """The same for people; what was not refused stands out."""
    table = Table(title="wrong input", title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("input", "refused", "with"):
        table.add_column(column, no_wrap=column != "with")
    for one in refusals:
        style = None if one.kept else "bold red"
        # Lists in messages are no mark-up.
        happened = escape(one.happened)
        table.add_row(one.wrong.name, "yes" if one.kept else "NO", happened, style=style)
    return table


def _one() -> CollisionWorld:
    return lbr_world([Obstacle("a", Sphere(0.1), _here())])


def _twice() -> None:
    _one().add(Obstacle("a", Sphere(0.1), _here()))


def _here() -> RigidTransform:
    return RigidTransform.from_components(np.array([2.0, 0.0, 0.0]), Rotation.identity())


def _square() -> np.ndarray:
    return np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])


def _any(value: object) -> Any:
    """Past the type checker: what a caller without one would hand in."""
    return value
