"""One table cleared under stress: set up, disturbed at a chosen moment, judged by the truth."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, get_args

import numpy as np

from eyehand.data_synth import DepthNoise, import_mujoco
from eyehand.data_synth.cell import GraspCell, GraspWorld, SimRobot
from eyehand.grasping import (
    Cell,
    ClearOptions,
    CycleInfo,
    PickOptions,
    PickOutcome,
    Tray,
    clear_table,
)
from eyehand.perception import perceive

from ...bench.sweep import Trial
from ..true_scene import known_scene
from ..true_solids import true_solids
from .dials import DEFAULT, perception_dial
from .trial import SETTLE_SECONDS, GraspTrial, Scorer

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from eyehand.data_synth.scenes import TabletopObject
    from eyehand.grasping import ClearReport, Phase
    from eyehand.perception import DepthFrame, Scene

    from .trial import PickRow


FLUNG_SPEED = 3.0
"""An object faster than this was flung, m/s: what drops from the hand at its highest is slower."""
STRAY = 0.02
"""How far past the edge of the table or tray an object's middle may come to rest, m."""
VANISHED = np.array([6.0, 6.0, 0.2])
"""Where an object goes that vanishes, world, m: past all that the camera sees."""
SOON = 4
"""Most picks of one trial: an object is tried twice, two are put away."""


@dataclass(frozen=True)
class GraspFigures:
    """What a trial measured, for the table behind the chart."""

    placed_pct: float | None
    """Objects in the tray at the end, of those that are still there; None when none is."""
    picks: int
    """Picks that were begun."""
    peak_speed_m_s: float
    """Of the fastest object."""
    touched_before: int
    """Other things than the object that the robot touched before a grasp."""
    creep_mm: float | None
    """How far the object moved in the hand while it was held up; None when none was."""


@dataclass
class Bench:
    """A cell with a robot under stress.

    Parameters
    ----------
    cell, robot
        As built; the cell's robot may be put behind another.
    """

    cell: Cell
    robot: SimRobot
    gone: set[str] = field(default_factory=set)
    """Objects that vanished: nothing is asked of them."""
    after_look: Callable[[], None] | None = None
    """What happens between the first choice and its motion."""
    disturb: Callable[[], None] | None = None
    """What happens in the phase named ..."""
    phase: Phase = "observe"
    """... here, once, in the middle of it."""
    waits: int = 5
    """Control periods of that phase before it happens."""

    def __post_init__(self) -> None:
        self.peak = 0.0
        """Speed of the fastest object so far, m/s."""
        self.finite = True
        """Whether all of the state has been finite."""
        self.creep: float | None = None
        """How far the object moved in the hand while held up, m."""
        self._held = ""
        self._grasped = np.zeros(3)
        model = self.robot.model
        starts = [
            int(model.jnt_dofadr[model.body_jntadr[model.body(name).id]])
            for name in self.robot.object_names
        ]
        self._rates = np.array([[d, d + 1, d + 2] for d in starts], dtype=np.intp).reshape(-1, 3)
        self.cell.on_cycle = self._note_cycle

    def put(self, name: str, place: NDArray[np.float64]) -> None:
        """Put an object somewhere else, at rest, (3,), world, m."""
        model, data = self.robot.model, self.robot.data
        joint = int(model.body_jntadr[model.body(name).id])
        at, rate = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        data.qpos[at : at + 3] = place
        data.qvel[rate : rate + 6] = 0.0
        import_mujoco().mj_forward(model, data)

    def vanish(self, name: str) -> None:
        """Take an object away, out of all sight."""
        self.gone.add(name)
        self.put(name, VANISHED)

    def set_rolling(self, friction: float) -> None:
        """Set the rolling friction of objects and table, m."""
        model = self.robot.model
        for name in ("table", *self.robot.object_names):
            model.geom_friction[model.geom(name).id, 2] = friction

    def clear(self, picks: int = SOON) -> Ended:
        """Clear the table."""
        began = time.process_time()
        scorer = Scorer(self.cell, self.robot)
        first = [self.after_look]

        def on_pick(choice, report) -> None:
            scorer.on_pick(choice, report)
            if report is None and first and (hook := first.pop()) is not None:
                hook()

        report = clear_table(self.cell, None, ClearOptions(picks=picks), on_pick)
        seconds = time.process_time() - began
        result = scorer.result(GraspTrial(), report, seconds)
        self._watch_speed()
        return Ended(self, report, result.picks, seconds)

    def _note_cycle(self, cycle: CycleInfo) -> None:
        self._watch_speed()
        if self.disturb is not None and cycle.phase == self.phase:
            self.waits -= 1
            if self.waits <= 0:
                happens, self.disturb = self.disturb, None
                happens()
        if cycle.phase == "check":
            self._watch_creep()

    def _watch_speed(self) -> None:
        data = self.robot.data
        self.finite = self.finite and bool(np.isfinite(data.qpos).all())
        speeds = np.linalg.norm(data.qvel[self._rates], axis=1)
        self.peak = max(self.peak, float(speeds.max(initial=0.0)))

    def _watch_creep(self) -> None:
        held = [name for name in self.robot.object_names if self.robot.lifted(name)]
        if len(held) != 1:
            return
        place = self.robot.object_pose(held[0]).translation
        now = self.cell.palm_pose().inv().apply(place)
        if held[0] != self._held:
            self._held, self._grasped = held[0], now
        self.creep = max(self.creep or 0.0, float(np.linalg.norm(now - self._grasped)))


@dataclass(frozen=True)
class Ended:
    """How a clearing under stress ended."""

    bench: Bench
    """Cell and truth, as left."""
    report: ClearReport
    """What the robot says."""
    picks: tuple[PickRow, ...]
    """The same held against the truth."""
    cpu_seconds: float
    """What it took."""

    @property
    def there(self) -> tuple[str, ...]:
        """Objects that did not vanish."""
        bench = self.bench
        return tuple(name for name in bench.robot.object_names if name not in bench.gone)

    @property
    def left(self) -> tuple[str, ...]:
        """Objects of those that are not in the tray."""
        return tuple(name for name in self.there if not self.bench.robot.in_tray(name))

    @property
    def refused(self) -> bool:
        """Whether nothing was tried, and the reason was given."""
        return not self.picks and self.report.stop_reason != "clear"

    @property
    def says(self) -> str:
        """What the robot says of what did not go well."""
        bad = next((row for row in reversed(self.picks) if not row.success), None)
        if bad is not None:
            return f"{bad.outcome}: {bad.reason}"
        return self.report.remaining[0] if self.report.remaining else self.report.stop_reason

    @property
    def fault(self) -> str:
        """What no answer may be, whatever is asked; empty when it was a proper one."""
        bench = self.bench
        told = {row.reason or row.outcome for row in self.picks if row.outcome != "placed"}
        if not bench.finite:
            return "a state that is not finite"
        if bench.peak > FLUNG_SPEED:
            return f"an object was flung at {bench.peak:.1f} m/s"
        if touched := sum(row.touched_before for row in self.picks):
            return f"{touched} other things touched before a grasp; {self.says}"
        if not {row.outcome for row in self.picks} <= set(get_args(PickOutcome)) or "" in told:
            return "a pick without a named outcome"
        if any(row.outcome == "placed" and not row.success for row in self.picks):
            return "says placed, but it is not in the tray"
        if self.report.stop_reason == "clear" and self.left:
            return f"says clear while {len(self.left)} stand on the table"
        return self._strayed()

    def _strayed(self) -> str:
        cell = self.bench.robot.world.cell
        half = 0.5 * np.asarray(cell.table.size) + STRAY
        for name in self.there:
            place = self.bench.robot.object_pose(name).translation
            on_table = bool((np.abs(place[:2]) <= half).all())
            if not on_table and not cell.is_over_tray(place):
                return f"{name} left the table, to {np.round(place[:2], 2).tolist()} m"
        return ""

    def judged(self, passed: bool | None = None, note: str = "") -> Trial:
        """Make a trial of it; right is, where nothing else is said, that all is in the tray."""
        right = (not self.left) if passed is None else passed
        there, creep = len(self.there), self.bench.creep
        share = 1.0 - len(self.left) / there if there else None
        figures = GraspFigures(
            placed_pct=None if share is None else 100.0 * share,
            picks=len(self.picks),
            peak_speed_m_s=self.bench.peak,
            touched_before=sum(row.touched_before for row in self.picks),
            creep_mm=None if creep is None else 1e3 * creep,
        )
        fault = self.fault
        return Trial(
            right and not fault,
            "" if right and not fault else fault or note or self.says,
            clean=not fault,
            score=share,
            seconds=self.cpu_seconds,
            refused=self.refused,
            picture=figures,
        )


def bench_of(
    objects: Sequence[TabletopObject],
    seed: int,
    options: PickOptions,
    *,
    friction: float = 1.0,
    known: bool = True,
    places: GraspCell | None = None,
) -> Bench:
    """Build a cell with objects at rest.

    Parameters
    ----------
    objects
        What stands on the table.
    seed
        Of the camera's noise.
    options
        Of the pick.
    friction
        Sliding friction of the hand on everything.
    known
        Whether the true solids are seen, in place of the camera's view: what breaks then is
        choice, motion or grip.
    places
        Where everything stands.
    """
    world = GraspWorld.build(objects, friction=friction, cell=places)
    robot = SimRobot(world, noise=DepthNoise.realistic(), seed=seed)
    where = world.cell
    tray = Tray(np.array(where.tray_centre), where.tray_size, where.tray_height)
    bench: list[Bench] = []

    def seen(frame: DepthFrame) -> Scene:
        return perceive(frame, perception_dial(DEFAULT))

    def true_scene(frame: DepthFrame) -> Scene:
        assert frame.T_world_camera is not None
        solids = [one for one in true_solids(robot) if one.name not in bench[0].gone]
        return known_scene(
            solids, frame.T_world_camera.translation, table_height=where.table.height
        )

    cell = Cell(robot, true_scene if known else seen, tray, options)
    cell.wait(SETTLE_SECONDS)
    bench.append(Bench(cell, robot))
    return bench[0]
