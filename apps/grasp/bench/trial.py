"""One trial: clear a simulated table and score the picks against the ground truth."""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from eyehand.data_synth import DepthNoise
from eyehand.data_synth.cell import INCLUDED_ARM, GraspRobot, GraspWorld, SimRobot, make_robot
from eyehand.data_synth.pad import SENSORS, SensorModel
from eyehand.data_synth.scenes import MeshObject, Split, TabletopObject
from eyehand.grasping import (
    Cell,
    ClearOptions,
    ClearReport,
    CycleInfo,
    GraspOptions,
    GraspPurpose,
    ParallelHand,
    PickOptions,
    PickReport,
    SelectedGrasp,
    Tray,
    clear_table,
)
from eyehand.perception import DepthFrame, PerceiveOptions, Scene, perceive

from ...bench.peak_memory import return_free_pages
from ..ground_truth_scene import ground_truth_scene
from ..mesh_scenes import ObjectSource, mesh_scene
from ..scenes import GraspFamily, grasp_scene
from ..true_solids import nearest_object, true_solids
from .dials import DEFAULT, control_dial, perception_dial
from .displacement import Displacement
from .held_load import HeldLoad, predicted_hold
from .pick_row import PickRow
from .unattempted import UnattemptedObject, too_wide_objects, unattempted_objects

SETTLE_SECONDS = 0.3
"""Waiting time before the first capture, s. Dropped objects come to rest."""
FALL_SECONDS = 2.5
"""Waiting time for objects that start in the air, s."""
BEFORE_GRASP = ("observe", "select", "pre-grasp", "approach", "contact")
"""Phases in which the robot must touch nothing but the target object."""


@dataclass(frozen=True)
class GraspTrial:
    """The scene, the conditions and the robot of a trial."""

    family: GraspFamily = "packed"
    """Arrangement of the objects."""
    seed: int = 0
    """Seed of the scene and of the camera noise."""
    objects: int = 5
    """Number of objects. A single scene always has one."""
    friction: float = 1.0
    """Coulomb friction coefficient of the hand's pads."""
    shake: float = 0.0
    """Duration of the shake after each lift, s."""
    load_step: float = 1.0
    """Load on the lifted object while the hand checks it, as a multiple of its weight."""
    known: bool = False
    """Whether the true solids replace perception."""
    purpose: GraspPurpose = "lift"
    """Purpose of the grasps."""
    perception: str = DEFAULT
    """Name of the perception dial."""
    control: str = DEFAULT
    """Name of the control dial."""
    objects_dir: str = ""
    """Folder of meshes or URDFs to draw objects from. If empty, solids are drawn."""
    split: Split = "all"
    """Half of that folder's objects that are drawn, by their names."""
    density: float = 0.0
    """Density of the objects of that folder, kg/m³; 0 for the masses of their files."""
    robot: str = ""
    """MJCF file of another robot. If empty, the default robot is used."""
    hand_frame: str = ""
    """Name of the hand frame of that robot."""
    arm: str = ""
    """Name or file of an arm for `make_robot`. If empty, `robot` or the default robot is used."""
    hand: str = ""
    """Name or file of its hand; empty for the arm's own."""
    mount: str = ""
    """Pose of the hand in the arm's flange: "x y z roll pitch yaw", m and rad. Empty for the
    default."""
    sensor: str = ""
    """Sensor model of the hand's pads, one of `SENSORS`. If empty, touch is exact."""


@dataclass(frozen=True)
class TrialResult:
    """The result of a trial."""

    trial: GraspTrial
    """The trial."""
    picks: tuple[PickRow, ...]
    """All picks."""
    placed: int
    """Number of objects in the tray at the end."""
    total: int
    """Number of objects at the start."""
    left: int
    """Number of objects outside the tray at the end."""
    stopped: str
    """Reason why the robot stopped."""
    cpu_seconds: float
    """Processor time of this process, s."""
    untried: tuple[UnattemptedObject, ...] = ()
    """Objects that no pick attempted. Each counts as a failed pick."""
    work_seconds: float = 0.0
    """Simulated time of all motions, with the ways home, and computing time of perception and
    planning, s."""


def run_trial(trial: GraspTrial) -> TrialResult:
    """Clear a table and return the scored picks.

    Raises
    ------
    InputError
        If a dial, a folder or a robot of the trial is invalid.
    """
    began = time.process_time()
    cell, robot = make_cell(trial)
    scorer = Scorer(cell, robot, trial.load_step, trial.friction)

    def on_pick(choice: SelectedGrasp, report: PickReport | None) -> None:
        scorer.on_pick(choice, report)
        # The planner frees 100 MB per pick.
        return_free_pages()

    report = clear_table(cell, GraspOptions(purpose=trial.purpose), ClearOptions(), on_pick)
    return scorer.result(trial, report, time.process_time() - began)


def make_cell(trial: GraspTrial) -> tuple[Cell, SimRobot]:
    """Build the simulated cell of a trial, with its objects at rest.

    Raises
    ------
    InputError
        If a dial, a folder or a robot of the trial is invalid.
    """
    if trial.objects_dir:
        source = ObjectSource(trial.objects_dir, trial.split, trial.density or None)
        items = mesh_scene(source, trial.family, trial.seed, trial.objects)
    else:
        items = grasp_scene(trial.family, trial.seed, trial.objects).objects
    return trial_cell(items, trial)


def trial_cell(
    objects: Sequence[TabletopObject | MeshObject], trial: GraspTrial
) -> tuple[Cell, SimRobot]:
    """Build the cell of a trial around given objects; the scene of the trial is not used."""
    world = GraspWorld.build(objects, robot=_trial_robot(trial), friction=trial.friction)
    options = replace(control_dial(trial.control), shake_seconds=trial.shake)
    perception = None if trial.known else perception_dial(trial.perception)
    sensor = SENSORS[trial.sensor] if trial.sensor else None
    cell, robot = build_cell(world, trial.seed, options, perception, sensor=sensor)
    cell.wait(FALL_SECONDS if trial.objects_dir else SETTLE_SECONDS)
    return cell, robot


def _trial_robot(trial: GraspTrial) -> GraspRobot | None:
    """Return the robot of a trial; None for the default one."""
    if trial.robot:
        return GraspRobot.of_file(Path(trial.robot), trial.hand_frame)
    if trial.arm or trial.hand:
        mount = tuple(float(word) for word in trial.mount.split())
        return make_robot(trial.arm or INCLUDED_ARM, trial.hand, mount or None)
    return None


def build_cell(
    world: GraspWorld,
    seed: int,
    options: PickOptions,
    perception: PerceiveOptions | None,
    removed: Collection[str] = (),
    sensor: SensorModel | None = None,
) -> tuple[Cell, SimRobot]:
    """Build the cell and the simulated robot of a world.

    Parameters
    ----------
    world
        Table, tray, camera, robot and objects.
    seed
        Seed of the camera noise.
    options
        Options of the picks.
    perception
        Options of perception. None replaces perception by the true solids.
    removed
        Names of objects that left the scene. The true solids leave them out.
    sensor
        Sensor model of the hand's pads. None: touch is exact.
    """
    robot = SimRobot(world, noise=DepthNoise.realistic(), seed=seed, sensor=sensor)
    place = world.cell

    def perceive_frame(frame: DepthFrame) -> Scene:
        if perception is not None:
            return perceive(frame, perception)
        assert frame.T_world_camera is not None
        solids = [solid for solid in true_solids(robot) if solid.name not in removed]
        view_origin = frame.T_world_camera.translation
        return ground_truth_scene(solids, view_origin, table_height=place.table.height)

    tray = Tray(np.array(place.tray_centre), place.tray_size, place.tray_height)
    return Cell(robot, perceive_frame, tray, options), robot


class Scorer:
    """A recorder that scores the picks of a robot against the ground truth.

    Parameters
    ----------
    cell, robot
        The cell and its simulated robot. An existing `on_cycle` callback of the cell is kept.
    load_step
        Load on the lifted object during its check, as a multiple of its weight.
    friction
        Sliding friction of the hand's pads.
    """

    def __init__(
        self, cell: Cell, robot: SimRobot, load_step: float = 1.0, friction: float = 1.0
    ) -> None:
        self._cell, self._robot = cell, robot
        self._on_cycle = cell.on_cycle
        cell.on_cycle = self._note_cycle
        self._rows: list[PickRow] = []
        self._start = cell.reading.time
        self._target, self._began = "", 0.0
        self._touched = set[str]()
        self._grasping = False
        self._moved = Displacement(robot, "")
        self._load_step, self._friction = load_step, friction
        self._held = HeldLoad(robot, "", load_step, friction)

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Record a pick: before it, with None, and after it, with its report."""
        if report is None:
            # A segment may hold several objects. The fingers close on one of them.
            geometry, points = choice.plan.geometry, choice.target.points
            place = geometry.centre if geometry else points.mean(axis=0)
            self._target = nearest_object(self._robot, place)
            self._began = time.perf_counter()
            self._robot.take_contacts()
            self._touched, self._grasping = set(), False
            self._moved = Displacement(self._robot, self._target)
            self._held = HeldLoad(self._robot, self._target, self._load_step, self._friction)
            return
        self._held.end()
        plan = report.plan
        touched = self._touched - {self._target}
        # A pushing grasp may touch neighbours, but never the table or the tray.
        intended = touched.intersection(self._robot.object_names) if plan.may_push else set()
        # Without a target, every object was in the tray already: nothing was picked.
        success = bool(report and self._target) and self._robot.is_in_tray(self._target)
        missing = report.outcome in ("slipped", "lost") or (bool(report) and not success)
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
                success=success,
                perceive_ms=report.perceive_ms,
                plan_ms=report.plan_ms,
                seconds=report.seconds,
                wall_seconds=time.perf_counter() - self._began,
                touched_before=len(touched - intended),
                pads=report.contact_pads,
                curl=report.finger_curl,
                pushed=plan.may_push,
                touched_pushing=len(intended),
                displacement=self._moved.metres,
                score=plan.score.total,
                hold=predicted_hold(choice, self._robot.hand),
                lifted=self._held.lifted,
                kept=self._held.lifted and not missing,
                squeeze=self._held.squeeze,
            )
        )

    def result(self, trial: GraspTrial, report: ClearReport, cpu_seconds: float) -> TrialResult:
        """Return the result of the trial."""
        names = self._robot.object_names
        placed = sum(self._robot.is_in_tray(name) for name in names)
        hand = self._robot.hand
        stroke = hand.stroke if isinstance(hand, ParallelHand) else np.inf
        return TrialResult(
            trial=trial,
            picks=tuple(self._rows),
            placed=placed,
            total=len(names),
            left=len(names) - placed,
            stopped=report.stop_reason,
            cpu_seconds=cpu_seconds,
            work_seconds=self._cell.reading.time - self._start + 1e-3 * report.compute_ms,
            untried=unattempted_objects(
                [name for name in names if not self._robot.is_in_tray(name)],
                [row.object for row in self._rows],
                report,
                self._cell,
                partial(nearest_object, self._robot),
                too_wide_objects(self._robot.world.objects, stroke),
            ),
        )

    def _note_cycle(self, cycle: CycleInfo) -> None:
        self._held.update(cycle)
        if not self._grasping or self._moved.active:
            touched = self._robot.take_contacts()
            self._moved.update(cycle.phase, touched)
            self._touched |= set() if self._grasping else touched
            self._grasping = self._grasping or cycle.phase not in BEFORE_GRASP
        if self._on_cycle is not None:
            self._on_cycle(cycle)
