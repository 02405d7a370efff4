"""A stress trial of picking: build a cell, disturb it, and check the outcome against the truth."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, get_args

import numpy as np

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import GraspCell, GraspWorld, SimRobot
from eyehand.grasping import Cell, ClearOptions, CycleInfo, PickOptions, PickOutcome, clear_table

from ...bench.sweep import Trial
from .dials import DEFAULT, perception_dial
from .trial import SETTLE_SECONDS, GraspTrial, Scorer, build_cell

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from eyehand.data_synth.scenes import MeshObject, TabletopObject
    from eyehand.grasping import ClearReport, Phase

    from .pick_row import PickRow

MAX_OBJECT_SPEED = 3.0
"""Maximum speed of an object, m/s. A faster one was thrown; an object that drops is slower."""
EDGE_MARGIN = 0.02
"""Maximum distance of an object's centre past the edge of the table, m."""
REMOVED_POSITION = np.array([6.0, 6.0, 0.2])
"""Position of a removed object, world, m, outside the view of the camera."""
MAX_PICKS = 4
"""Maximum number of picks of one trial."""


@dataclass(frozen=True)
class GraspFigures:
    """The measured figures of a trial, for the table behind the chart."""

    placed_pct: float | None
    """Percentage of the remaining objects that are in the tray; None without objects."""
    picks: int
    """Number of picks."""
    peak_speed_m_s: float
    """Peak speed of the fastest object, m/s."""
    touched_before: int
    """Number of other bodies that the robot touched before a grasp by mistake."""
    creep_mm: float | None
    """Motion of the held object in the hand, mm; None if no object was held."""


@dataclass
class StressCell:
    """A simulated cell that a trial disturbs.

    Parameters
    ----------
    cell, robot
        The cell and its simulated robot. A sweep may wrap the robot of the cell.
    """

    cell: Cell
    robot: SimRobot
    removed: set[str] = field(default_factory=set)
    """Names of the removed objects. They need not be in the tray."""
    after_selection: Callable[[], None] | None = None
    """Action between the first grasp selection and its motion."""
    disturb: Callable[[], None] | None = None
    """Action in `disturbed_phase`. It happens once."""
    disturbed_phase: Phase = "observe"
    """Phase of the disturbance."""
    delay_cycles: int = 5
    """Number of control cycles between the start of that phase and the disturbance."""

    def __post_init__(self) -> None:
        self.peak_speed = 0.0
        """Peak speed of the fastest object, m/s."""
        self.finite = True
        """Whether the simulation state was always finite."""
        self.creep: float | None = None
        """Motion of the held object in the hand, m; None if no object was held."""
        self._held_name = ""
        self._grasp_position = np.zeros(3)
        model = self.robot.model
        velocity_starts = [
            int(model.jnt_dofadr[model.body_jntadr[model.body(name).id]])
            for name in self.robot.object_names
        ]
        self._velocity_indices = np.array(
            [[d, d + 1, d + 2] for d in velocity_starts], dtype=np.intp
        ).reshape(-1, 3)
        self.cell.on_cycle = self._note_cycle

    def move_object(self, name: str, position: NDArray[np.float64]) -> None:
        """Move an object to a position (3,), world, m, at rest."""
        model, data = self.robot.model, self.robot.data
        joint = int(model.body_jntadr[model.body(name).id])
        start, velocity_start = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        data.qpos[start : start + 3] = position
        data.qvel[velocity_start : velocity_start + 6] = 0.0
        import_mujoco().mj_forward(model, data)

    def remove_object(self, name: str) -> None:
        """Move an object out of the view of the camera."""
        self.removed.add(name)
        self.move_object(name, REMOVED_POSITION)

    def set_rolling(self, friction: float) -> None:
        """Set the rolling friction of objects and table, m."""
        model = self.robot.model
        for name in ("table", *self.robot.object_names):
            model.geom_friction[model.geom(name).id, 2] = friction

    def clear(self, picks: int = MAX_PICKS) -> StressOutcome:
        """Clear the table with at most `picks` picks."""
        began = time.process_time()
        scorer = Scorer(self.cell, self.robot)
        actions = [self.after_selection]

        def on_pick(choice, report) -> None:
            scorer.on_pick(choice, report)
            if report is None and actions and (action := actions.pop()) is not None:
                action()

        report = clear_table(self.cell, None, ClearOptions(picks=picks), on_pick)
        seconds = time.process_time() - began
        result = scorer.result(GraspTrial(), report, seconds)
        self._record_speed()
        return StressOutcome(self, report, result.picks, seconds)

    def _note_cycle(self, cycle: CycleInfo) -> None:
        self._record_speed()
        if self.disturb is not None and cycle.phase == self.disturbed_phase:
            self.delay_cycles -= 1
            if self.delay_cycles <= 0:
                action, self.disturb = self.disturb, None
                action()
        if cycle.phase == "check":
            self._record_creep()

    def _record_speed(self) -> None:
        data = self.robot.data
        self.finite = self.finite and bool(np.isfinite(data.qpos).all())
        speeds = np.linalg.norm(data.qvel[self._velocity_indices], axis=1)
        self.peak_speed = max(self.peak_speed, float(speeds.max(initial=0.0)))

    def _record_creep(self) -> None:
        held = [name for name in self.robot.object_names if self.robot.is_lifted(name)]
        if len(held) != 1:
            return
        position = self.robot.object_pose(held[0]).translation
        now = self.cell.palm_pose().inv().apply(position)
        if held[0] != self._held_name:
            self._held_name, self._grasp_position = held[0], now
        self.creep = max(self.creep or 0.0, float(np.linalg.norm(now - self._grasp_position)))


@dataclass(frozen=True)
class StressOutcome:
    """The outcome of a stress trial."""

    stress: StressCell
    """The cell after the trial."""
    report: ClearReport
    """Report of the robot."""
    picks: tuple[PickRow, ...]
    """Picks scored against the ground truth."""
    cpu_seconds: float
    """Processor time of the trial, s."""

    @property
    def remaining(self) -> tuple[str, ...]:
        """Names of the objects that were not removed."""
        stress = self.stress
        return tuple(name for name in stress.robot.object_names if name not in stress.removed)

    @property
    def left(self) -> tuple[str, ...]:
        """Names of the remaining objects that are not in the tray."""
        return tuple(name for name in self.remaining if not self.stress.robot.is_in_tray(name))

    @property
    def refused(self) -> bool:
        """Whether the robot stopped without a pick and gave a reason."""
        return not self.picks and not self.report.cleared

    @property
    def failure(self) -> str:
        """The reason of the last failure, as reported by the robot."""
        failed = next((row for row in reversed(self.picks) if not row.success), None)
        if failed is not None:
            return f"{failed.outcome}: {failed.reason}"
        return self.report.remaining[0] if self.report.remaining else self.report.stop_reason

    @property
    def violation(self) -> str:
        """The violated rule that every trial must keep; empty if none is."""
        stress = self.stress
        reasons = {row.reason or row.outcome for row in self.picks if row.outcome != "placed"}
        if not stress.finite:
            return "a state that is not finite"
        if stress.peak_speed > MAX_OBJECT_SPEED:
            return f"an object was thrown at {stress.peak_speed:.1f} m/s"
        if touched := sum(row.touched_before for row in self.picks):
            return f"{touched} other bodies touched before a grasp; {self.failure}"
        if not {row.outcome for row in self.picks} <= set(get_args(PickOutcome)) or "" in reasons:
            return "a pick without a named outcome"
        if any(row.outcome == "placed" and not row.success for row in self.picks):
            return "reported placed, but the object is not in the tray"
        if self.report.cleared and self.left:
            return f"reported clear with {len(self.left)} on the table"
        return self._off_table()

    def _off_table(self) -> str:
        """Describe an object that left both table and tray; empty if none did."""
        cell = self.stress.robot.world.cell
        half = 0.5 * np.asarray(cell.table.size) + EDGE_MARGIN
        for name in self.remaining:
            position = self.stress.robot.object_pose(name).translation
            on_table = bool((np.abs(position[:2]) <= half).all())
            if not on_table and not cell.is_over_tray(position):
                return f"{name} left the table, to {np.round(position[:2], 2).tolist()} m"
        return ""

    def trial(self, passed: bool | None = None, note: str = "") -> Trial:
        """Return the trial of a sweep. By default it passes if all objects are in the tray."""
        right = (not self.left) if passed is None else passed
        remaining, creep = len(self.remaining), self.stress.creep
        share = 1.0 - len(self.left) / remaining if remaining else None
        figures = GraspFigures(
            placed_pct=None if share is None else 100.0 * share,
            picks=len(self.picks),
            peak_speed_m_s=self.stress.peak_speed,
            touched_before=sum(row.touched_before for row in self.picks),
            creep_mm=None if creep is None else 1e3 * creep,
        )
        violation = self.violation
        return Trial(
            right and not violation,
            "" if right and not violation else violation or note or self.failure,
            clean=not violation,
            score=share,
            seconds=self.cpu_seconds,
            refused=self.refused,
            picture=figures,
        )


def stress_cell(
    objects: Sequence[TabletopObject | MeshObject],
    seed: int,
    options: PickOptions,
    *,
    friction: float = 1.0,
    known: bool = True,
    geometry: GraspCell | None = None,
) -> StressCell:
    """Build a cell with objects at rest.

    Parameters
    ----------
    objects
        Objects on the table.
    seed
        Seed of the camera noise.
    options
        Options of the picks.
    friction
        Coulomb friction coefficient of the hand's pads.
    known
        Whether the true solids replace perception. A failure is then one of selection, motion or
        grip.
    geometry
        Poses of table, tray, camera and robot; default: the standard cell.
    """
    world = GraspWorld.build(objects, friction=friction, cell=geometry)
    removed: set[str] = set()
    perception = None if known else perception_dial(DEFAULT)
    cell, robot = build_cell(world, seed, options, perception, removed)
    cell.wait(SETTLE_SECONDS)
    return StressCell(cell, robot, removed)
