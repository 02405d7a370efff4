"""Clear a table: look, choose, pick, look again, until nothing is left that can be had."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control import CollisionWorld, PlannedApproach
from eyehand.control.tasks import Posture
from eyehand.errors import InputError

from .closing import open_command
from .frame_fusion import steady
from .grasp_selection import Chosen, choose, grasp_key
from .motion import bumped, go
from .obstacles import surroundings
from .pick import pick
from .pick_verification import SAME_PLACE, seen_after
from .planning import SelectOptions
from .report import ClearReport, PickReport
from .scene_validation import doubts

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.perception import DepthFrame, Scene

    from .cell import Cell
    from .pick_state import Choice
    from .tray import Tray

HOME_SPEED = 2.0
"""Largest norm of the joint velocities on the way to the rest posture, rad/s."""
HOME_SECONDS = 6.0
"""Longest such way, s."""
LOOKS = 5
"""Depth images of which a look that leaves a doubt is made: what is lost in one is there in
another, and a camera takes so many in a fifth of a second."""


@dataclass(frozen=True)
class ClearOptions:
    """When clearing ends."""

    failures: int = 2
    """Failed picks in a row after which it ends: the rule of the clutter-removal benchmarks."""
    picks: int = 40
    """Most picks."""
    push: bool = True
    """Whether fingers may push neighbours aside where nothing else is left: the last objects of a
    pile lie in each other's way, and contact is meant then."""
    look_from_tray: bool = True
    """Whether to look while the hand is still over the tray: saves the way to the rest posture,
    where the tray stands beside what the camera is to see."""


@dataclass
class Memory:
    """What was tried before, by place."""

    places: list[NDArray[np.float64]] = field(default_factory=list)
    """Where objects were that a pick failed on, each (3,), m."""
    ways: list[set[str]] = field(default_factory=list)
    """Ways tried there, by name."""

    def tried(self, place: NDArray[np.float64]) -> set[str]:
        """Ways tried on what stands at a place (3,)."""
        number = self._find(place)
        return self.ways[number] if number is not None else set()

    def note(self, place: NDArray[np.float64], way: str) -> None:
        """Remember that a way failed there."""
        number = self._find(place)
        if number is None:
            self.places.append(place)
            self.ways.append({way})
        else:
            self.places[number] = place
            self.ways[number].add(way)

    def _find(self, place: NDArray[np.float64]) -> int | None:
        apart = [float(np.linalg.norm(place - other)) for other in self.places]
        return int(np.argmin(apart)) if apart and min(apart) < SAME_PLACE else None


def clear_table(
    cell: Cell,
    select: SelectOptions | None = None,
    options: ClearOptions | None = None,
    told: Callable[[Choice, PickReport | None], None] | None = None,
) -> ClearReport:
    """Put everything on the table that can be grasped into the tray.

    Parameters
    ----------
    cell
        The robot at rest.
    select
        How grasps are chosen.
    options
        When to end.
    told
        Told of every pick before it, with None, and after it, with its report, once a look has
        shown what became of it.
    """
    options = options or ClearOptions()
    picks: list[PickReport] = []
    memory = Memory()
    looks = 0
    away = False
    scene: Scene | None = None
    last: Choice | None = None
    # What the next pick waits for, of all looks and searches since the one before.
    perceive_ms = plan_ms = 0.0
    while True:
        seen, seeing_ms, doubt = look(cell)
        perceive_ms += seeing_ms
        looks += 1
        if seen is None:
            if scene is not None and away and not cell.reading.fault:
                # The arm over the tray may be what the doubt comes from.
                go_home(cell, scene)
                away = False
                continue
            _tell(told, last, picks)
            return ClearReport(tuple(picks), looks, (), cell.reading.fault or doubt)
        scene = seen
        if last is not None:
            believed, picks[-1] = picks[-1], seen_after(picks[-1], last, scene, cell.tray)
            if believed and not picks[-1]:
                _remember(memory, last)
        failures = _failed_in_a_row(picks)
        stopped = ""
        if cell.reading.fault:
            stopped = cell.reading.fault
        elif not scene.objects:
            stopped = "clear"
        elif failures >= options.failures:
            stopped = f"{failures} picks failed in a row"
        elif len(picks) >= options.picks:
            stopped = f"{options.picks} picks made"
        chosen = (
            choose(cell, scene, memory, select, perceive_ms, plan_ms)
            if not stopped
            else Chosen(None, (), plan_ms)
        )
        plan_ms = chosen.plan_ms
        if not stopped and chosen.choice is None:
            stopped = "nothing left that can be grasped"
        if away and stopped in ("clear", "nothing left that can be grasped"):
            # The arm over the tray may hide something, or be where no way begins: look once more.
            go_home(cell, scene)
            away = False
            continue
        if stopped == "nothing left that can be grasped" and options.push:
            pushing = replace(select or SelectOptions(), push=True)
            chosen = choose(cell, scene, memory, pushing, perceive_ms, plan_ms)
            stopped = "" if chosen.choice is not None else stopped
        if stopped or chosen.choice is None:
            if away:
                go_home(cell, scene)
            left = chosen.left or tuple(f"object {one.label}: not tried" for one in scene.objects)
            _tell(told, last, picks)
            return ClearReport(tuple(picks), looks, left, cell.reading.fault or stopped)
        _tell(told, last, picks)
        last = chosen.choice
        if told is not None:
            told(last, None)
        perceive_ms = plan_ms = 0.0
        picks.append(pick(cell, last, sum(map(bool, picks))))
        if not picks[-1]:
            _remember(memory, last)
        away = bool(picks[-1]) and options.look_from_tray
        if picks[-1].outcome != "fault" and not away:
            go_home(cell, scene)


def look(cell: Cell) -> tuple[Scene | None, float, str]:
    """Take a depth image and see what is there; where that leaves a doubt, take more and fuse them.

    Gives the scene and the ms that seeing took; None where it is nothing to act on, and why.
    """
    cell.enter("look")
    frames: list[DepthFrame] = []
    spent, doubt = 0.0, ""
    for more in (1, LOOKS - 1):
        began = time.perf_counter()
        try:
            frames += [cell.robot.look() for _ in range(more)]
            began = time.perf_counter()
            frame = steady(frames)
            scene = _without_tray(cell.see(frame), cell.tray)
            doubt = doubts(frame, scene, cell.tray)
        except InputError as error:
            scene, doubt = None, f"cannot see: {error}"
        spent += 1e3 * (time.perf_counter() - began)
        if scene is not None and not doubt:
            cell.scene = scene
            return scene, spent, ""
    return None, spent, doubt


def go_home(cell: Cell, scene: Scene) -> bool:
    """Bring the arm to its rest posture, the hand open; tells whether it got there."""
    options = cell.options
    hand = cell.robot.hand
    world = CollisionWorld(
        cell.model(hand.pulled(hand.widest)),
        (*surroundings(scene, None), cell.tray.filled(cell.tray_height)),
    )
    control = replace(options.control, dt=cell.robot.period, tolerance=0.02)
    controller = PlannedApproach(
        world, (Posture(cell.home, speed=HOME_SPEED),), control, options.planner
    )
    command = open_command(hand)
    arrival = go(
        cell, controller, HOME_SECONDS, command=lambda _: command, stop=lambda r: bumped(cell, r)
    )
    return bool(arrival)


def _without_tray(scene: Scene, tray: Tray) -> Scene:
    objects = tuple(one for one in scene.objects if not tray.holds(one.points.mean(axis=0)))
    return replace(scene, objects=objects)


def _tell(
    told: Callable[[Choice, PickReport | None], None] | None,
    last: Choice | None,
    picks: list[PickReport],
) -> None:
    if told is not None and last is not None:
        told(last, picks[-1])


def _remember(memory: Memory, choice: Choice) -> None:
    place = choice.target.points.mean(axis=0)
    memory.note(place, grasp_key(choice.plan))


def _failed_in_a_row(picks: list[PickReport]) -> int:
    return len(picks) - max((k for k, one in enumerate(picks, start=1) if one), default=0)
