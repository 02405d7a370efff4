"""One trial: a simulated table is cleared, and the simulation's truth says how well."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth import DepthNoise
from eyehand.data_synth.cell import GraspRobot, GraspWorld, SimRobot
from eyehand.grasping import (
    Cell,
    ClearOptions,
    CycleInfo,
    GraspOptions,
    GraspPurpose,
    Tray,
    clear_table,
)
from eyehand.perception import perceive

from ..mesh_scenes import folder_scene
from ..scenes import GraspFamily, grasp_scene
from ..true_scene import known_scene
from ..true_solids import distances, true_solids
from .dials import DEFAULT, control_dial, perception_dial
from .unattempted import Untried, untried_objects

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from eyehand.data_synth.scenes import MeshObject, TabletopObject
    from eyehand.grasping import ClearReport, PickReport, SelectedGrasp
    from eyehand.perception import DepthFrame, Scene

SETTLE_SECONDS = 0.3
"""Robot time before the first look: what was dropped comes to rest on this world's table."""
FALL_SECONDS = 2.5
"""The same where objects begin in the air."""
BEFORE_GRASP = ("observe", "select", "pre-grasp", "approach", "contact")
"""Phases in which the robot is to touch nothing but the object."""


@dataclass(frozen=True)
class GraspTrial:
    """What is tried."""

    family: GraspFamily = "packed"
    """How the objects stand."""
    seed: int = 0
    """Of the scene and of the camera's noise."""
    objects: int = 5
    """How many, but for single ones."""
    friction: float = 1.0
    """Sliding friction of the hand's pads."""
    shake: float = 0.0
    """How long each object is shaken after the lift, s."""
    known: bool = False
    """Whether the true solids are known, in place of the camera's view."""
    purpose: GraspPurpose = "lift"
    """What the grasps are for."""
    perception: str = DEFAULT
    """Setting of perception by name."""
    control: str = DEFAULT
    """Setting of the pick by name."""
    objects_dir: str = ""
    """Folder of meshes or URDFs to draw objects from; empty draws solids."""
    robot: str = ""
    """MJCF file of another robot; empty takes the one that comes with eyehand."""
    hand_frame: str = ""
    """Name of its hand's frame."""


@dataclass(frozen=True)
class PickRow:
    """One pick, told in plain values."""

    pick: int
    """Its number, from 0."""
    object: str
    """True name of the object."""
    kind: str
    """Solid that it was taken for."""
    prototype: str
    """How the hand closed."""
    approach: str
    """Where the palm came from."""
    rows: int
    """Degrees of freedom that the approach took."""
    outcome: str
    """As the robot tells it."""
    reason: str
    """Why, where it failed."""
    success: bool
    """Whether it was held until it was let go in the tray, and lies there by the simulation's
    truth."""
    perceive_ms: float
    """Time of seeing, ms."""
    plan_ms: float
    """Time of choosing, ms."""
    seconds: float
    """Simulated time of the pick, s."""
    wall_seconds: float
    """Computing time of the pick, s."""
    touched_before: int
    """Other things than the object that the robot touched before the grasp without being meant to:
    those that a grasp may push aside are counted in `touched_pushing`."""
    pads: int
    """Pads in contact while held."""
    curl: float
    """How far the fingers bent around it, rad."""
    pushed: bool = False
    """Whether the grasp might push neighbours aside, as nothing else was left to try."""
    touched_pushing: int = 0
    """Neighbours that such a grasp touched before it."""


@dataclass(frozen=True)
class TrialResult:
    """How a trial went."""

    trial: GraspTrial
    """What was tried."""
    picks: tuple[PickRow, ...]
    """Every pick."""
    placed: int
    """Objects in the tray at the end."""
    total: int
    """Objects at the start."""
    left: int
    """Objects elsewhere at the end."""
    stopped: str
    """Why it ended."""
    cpu_seconds: float
    """Processor time of this process, s."""
    untried: tuple[Untried, ...] = ()
    """What no pick began on, though it was there: each counts as a pick that failed."""


def run_trial(
    trial: GraspTrial, on_cycle: Callable[[CycleInfo], None] | None = None
) -> TrialResult:
    """Clear a table, and tell how it went.

    Raises
    ------
    InputError
        If the trial asks for what there is not.
    """
    began = time.process_time()
    cell, robot = make_cell(trial, on_cycle)
    scorer = Scorer(cell, robot)
    report = clear_table(cell, GraspOptions(purpose=trial.purpose), ClearOptions(), scorer.on_pick)
    return scorer.result(trial, report, time.process_time() - began)


def make_cell(
    trial: GraspTrial, on_cycle: Callable[[CycleInfo], None] | None = None
) -> tuple[Cell, SimRobot]:
    """Build the simulated cell of a trial, its objects at rest.

    Raises
    ------
    InputError
        If the trial asks for what there is not.
    """
    if trial.objects_dir:
        items = folder_scene(trial.objects_dir, trial.family, trial.seed, trial.objects)
        return cell_of(items, trial, on_cycle)
    return cell_of(grasp_scene(trial.family, trial.seed, trial.objects).objects, trial, on_cycle)


def cell_of(
    objects: Sequence[TabletopObject | MeshObject],
    trial: GraspTrial,
    on_cycle: Callable[[CycleInfo], None] | None = None,
) -> tuple[Cell, SimRobot]:
    """Build a cell around given objects; of the trial, the scene is not looked at."""
    kind = None
    if trial.robot:
        kind = GraspRobot.of_file(Path(trial.robot), trial.hand_frame)
    world = GraspWorld.build(objects, robot=kind, friction=trial.friction)
    robot = SimRobot(world, noise=DepthNoise.realistic(), seed=trial.seed)
    perception = perception_dial(trial.perception)

    def perceive_frame(frame: DepthFrame) -> Scene:
        return _true_scene(robot, frame) if trial.known else perceive(frame, perception)

    places = world.cell
    tray = Tray(np.array(places.tray_centre), places.tray_size, places.tray_height)
    options = replace(control_dial(trial.control), shake_seconds=trial.shake)
    cell = Cell(robot, perceive_frame, tray, options)
    cell.wait(FALL_SECONDS if trial.objects_dir else SETTLE_SECONDS)
    cell.on_cycle = on_cycle
    return cell, robot


class Scorer:
    """Holds what the robot says of its picks against the simulation's truth.

    Parameters
    ----------
    cell, robot
        As made for the trial; the cell's `on_cycle` callback is called as well.
    """

    def __init__(self, cell: Cell, robot: SimRobot) -> None:
        self._cell = cell
        self._robot = robot
        self._on_cycle = cell.on_cycle
        cell.on_cycle = self._note_cycle
        self._rows: list[PickRow] = []
        self._target = ""
        self._began = 0.0
        self._touched: set[str] = set()
        self._grasping = False

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Take note of a pick: before it, with None, and after it."""
        if report is None:
            self._target = self._nearest(choice.target.points.mean(axis=0))
            self._began = time.perf_counter()
            self._robot.robot_contacts()
            self._touched, self._grasping = set(), False
            return
        plan = report.plan
        touched = self._touched - {self._target}
        # Neighbours may be pushed, table and tray never.
        meant = touched.intersection(self._robot.object_names) if plan.may_push else set()
        self._rows.append(
            PickRow(
                pick=len(self._rows),
                object=self._target,
                kind=report.kind,
                prototype=str(plan.prototype),
                approach=str(plan.approach),
                rows=plan.rows,
                outcome=report.outcome,
                reason=report.reason,
                success=bool(report) and self._robot.in_tray(self._target),
                perceive_ms=report.perceive_ms,
                plan_ms=report.plan_ms,
                seconds=report.seconds,
                wall_seconds=time.perf_counter() - self._began,
                touched_before=len(touched - meant),
                pads=report.contact_pads,
                curl=report.finger_curl,
                pushed=plan.may_push,
                touched_pushing=len(meant),
            )
        )

    def result(self, trial: GraspTrial, report: ClearReport, cpu_seconds: float) -> TrialResult:
        """Sum up."""
        names = self._robot.object_names
        placed = sum(self._robot.in_tray(name) for name in names)
        return TrialResult(
            trial=trial,
            picks=tuple(self._rows),
            placed=placed,
            total=len(names),
            left=len(names) - placed,
            stopped=report.stop_reason,
            cpu_seconds=cpu_seconds,
            untried=untried_objects(
                [name for name in names if not self._robot.in_tray(name)],
                [row.object for row in self._rows],
                report,
                self._cell,
                self._nearest,
            ),
        )

    def _note_cycle(self, cycle: CycleInfo) -> None:
        if not self._grasping:
            self._touched |= self._robot.robot_contacts()
            self._grasping = cycle.phase not in BEFORE_GRASP
        if self._on_cycle is not None:
            self._on_cycle(cycle)

    def _nearest(self, point: np.ndarray) -> str:
        """Name of the object that holds a point (3,), or whose surface is nearest to it.

        Signed: deep inside, the distance to the own surface exceeds that to a near neighbour.
        """
        apart = distances(self._robot, point)
        return min(apart, key=apart.__getitem__) if apart else ""


def _true_scene(robot: SimRobot, frame: DepthFrame) -> Scene:
    assert frame.T_world_camera is not None
    height = robot.world.cell.table.height
    return known_scene(true_solids(robot), frame.T_world_camera.translation, table_height=height)
