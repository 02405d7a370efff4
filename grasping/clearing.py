"""Clear a table: observe, verify, select and pick, until no graspable object is left."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

from eyehand.control import CollisionWorld, PlannedApproach
from eyehand.control.tasks import Posture

from .depth_change import DepthChange
from .failed_grasps import FailedGrasps
from .grasp_phases import NARROW
from .grasp_selection import GraspSelection, select_grasp
from .motion import execute, unexpected_contact
from .observation import observe
from .obstacles import scene_obstacles
from .pick import pick_object
from .pick_verification import verify_pick
from .planning import GraspOptions
from .report import CLEAR, NOT_TRIED, NOTHING_GRASPABLE, ClearReport, PickReport

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.perception import DepthFrame, Scene

    from .cell import Cell
    from .pick_state import SelectedGrasp
    from .tray import Tray

    Step: TypeAlias = "Callable[[_Clearing], Step | None]"

_log = logging.getLogger("eyehand")

HOME_SPEED = 7.0
"""Maximum norm of the joint velocities on the way to the rest posture at normal speed, rad/s."""
HOME_SECONDS = 6.0
"""Time limit of the motion to the rest posture, s."""
HOME_TOLERANCE = 0.02
"""Error at which the rest posture counts as reached, rad."""
REPEATED = "the depth image is identical to the one before the pick: check the camera"
"""Remark about a failed pick after which the camera returned the same image, bit by bit. A
simulated camera without noise does so at rest; a real one never does."""


@dataclass(frozen=True)
class ClearOptions:
    """Options of :func:`clear_table`."""

    failures: int = 2
    """Number of consecutive failed picks after which clearing ends. The benchmarks of clutter
    removal use 2."""
    picks: int = 40
    """Maximum number of picks."""
    push: bool = True
    """Whether the fingers may push neighbours aside when no other grasp is left. The last objects
    of a pile often block each other."""
    capture_over_tray: bool = True
    """Whether to capture the next image while the hand is still over the tray. This saves the
    motion to the rest posture. The tray must then be outside the region of interest."""


def clear_table(
    cell: Cell,
    grasp_options: GraspOptions | None = None,
    options: ClearOptions | None = None,
    on_pick: Callable[[SelectedGrasp, PickReport | None], None] | None = None,
) -> ClearReport:
    """Put all graspable objects on the table into the tray.

    The logger ``eyehand`` gets a line for each image and each pick, at the level INFO.

    Parameters
    ----------
    cell
        The robot at rest.
    grasp_options
        Options of grasp planning.
    options
        Options that decide when clearing ends.
    on_pick
        Callback before each pick, with None, and after it, with the verified report.
    """
    clearing = _Clearing(cell, grasp_options or GraspOptions(), options or ClearOptions(), on_pick)
    step: Step | None = _observe
    while step is not None:
        step = step(clearing)
    return clearing.report()


@dataclass
class _Clearing:
    """State of clearing a table, shared by its steps."""

    cell: Cell
    grasp_options: GraspOptions
    options: ClearOptions
    on_pick: Callable[[SelectedGrasp, PickReport | None], None] | None
    picks: list[PickReport] = field(default_factory=list)
    failed: FailedGrasps = field(default_factory=FailedGrasps)
    observations: int = 0
    scene: Scene | None = None
    """Last valid scene."""
    grasp: SelectedGrasp | None = None
    """Grasp of the last pick."""
    frame: DepthFrame | None = None
    """Depth image of the scene before this pick."""
    checksum: int | None = None
    """Checksum of the last depth image before this pick."""
    selection: GraspSelection = field(default_factory=lambda: GraspSelection(None, ()))
    """Last selection."""
    over_tray: bool = False
    """Whether the arm is over the tray instead of at rest."""
    perceive_ms: float = 0.0
    """Computing time of all observations since the last pick, ms."""
    plan_ms: float = 0.0
    """Computing time of all selections since the last pick, ms."""
    compute_ms: float = 0.0
    """Computing time of all observations and selections, ms."""
    missing: str = ""
    """Object that no image showed after its pick failed; empty if none."""
    stop_reason: str = ""
    remaining: tuple[str, ...] = ()

    def report(self) -> ClearReport:
        return ClearReport(
            tuple(self.picks),
            self.observations,
            self.remaining,
            self.stop_reason,
            self.compute_ms,
        )

    def report_last_pick(self) -> None:
        if self.grasp is None:
            return
        _log.info("pick %d: %s", len(self.picks), self.picks[-1])
        if self.on_pick is not None:
            self.on_pick(self.grasp, self.picks[-1])

    def add_failed_grasp(self) -> None:
        assert self.grasp is not None, "a pick has a grasp"
        grasp, slipped = self.grasp, self.picks[-1].outcome in ("slipped", "lost")
        self.failed.add(grasp.scene, grasp.target, grasp.plan, slipped=slipped)

    def move_home(self) -> None:
        assert self.scene is not None, "the arm moves after a valid observation"
        move_home(self.cell, self.scene)
        self.over_tray = False


def _observe(run: _Clearing) -> Step | None:
    """Perceive the scene; from the rest posture if the view from over the tray is not valid."""
    scene, milliseconds, problem = observe(run.cell)
    run.perceive_ms += milliseconds
    run.compute_ms += milliseconds
    run.observations += 1
    if scene is not None:
        found = f"{len(scene.objects)}{_height(scene, run.cell.tray)}"
        _log.info("image %d: objects on the table: %s", run.observations, found)
        run.scene = scene
        return _verify
    fault = run.cell.reading.fault
    if run.scene is not None and run.over_tray and not fault:
        # The arm over the tray may be the cause.
        run.move_home()
        return _observe
    _log.info("image %d: %s", run.observations, problem)
    run.report_last_pick()
    run.stop_reason = fault or problem
    run.remaining = _left(run, ())
    return None


def _verify(run: _Clearing) -> Step:
    """Correct the outcome of the last pick by the new scene."""
    if run.grasp is not None:
        assert run.scene is not None, "the scene is valid"
        believed = run.picks[-1]
        before, after = run.frame, run.cell.frame
        change = (
            DepthChange(before, run.grasp.scene, after, run.scene) if before and after else None
        )
        report = verify_pick(believed, run.grasp, run.scene, run.cell.tray, change)
        same = run.cell.image_checksum == run.checksum and REPEATED not in report.reason
        if same and report.outcome in ("empty_close", "no_contact"):
            report = replace(report, reason=f"{report.reason}; {REPEATED}")
        run.picks[-1] = report
        count = len(run.grasp.scene.objects)
        if len(run.scene.objects) > count:
            run.missing = ""
        elif not report and report.outcome != "wrong_object" and len(run.scene.objects) < count:
            run.missing = f"object {run.grasp.target.label} was not seen again: {report.outcome}"
        if believed and not report:
            run.add_failed_grasp()
    return _select


def _select(run: _Clearing) -> Step:
    """Select the next grasp, or the reason to stop."""
    run.selection = GraspSelection(None, (), run.plan_ms)
    run.stop_reason = _stop_reason(run)
    if not run.stop_reason:
        _run_selection(run, run.grasp_options)
        run.plan_ms = run.selection.plan_ms
    if run.over_tray and run.stop_reason in (CLEAR, NOTHING_GRASPABLE):
        # The arm over the tray may hide objects, or be a bad start of a motion.
        run.move_home()
        return _observe
    if run.stop_reason == NOTHING_GRASPABLE and run.options.push:
        _run_selection(run, replace(run.grasp_options, push=True))
    return _stop if run.stop_reason else _pick


def _run_selection(run: _Clearing, options: GraspOptions) -> None:
    assert run.scene is not None, "the scene is valid"
    run.selection = select_grasp(
        run.cell, run.scene, run.failed, options, run.perceive_ms, run.plan_ms
    )
    run.compute_ms += run.selection.plan_ms - run.plan_ms
    run.stop_reason = "" if run.selection.grasp is not None else NOTHING_GRASPABLE


def _pick(run: _Clearing) -> Step:
    """Pick the selected object."""
    run.report_last_pick()
    grasp = run.grasp = run.selection.grasp
    assert grasp is not None, "a grasp was selected"
    if run.on_pick is not None:
        run.on_pick(grasp, None)
    run.perceive_ms = run.plan_ms = 0.0
    run.checksum, run.frame = run.cell.image_checksum, run.cell.frame
    report = pick_object(run.cell, grasp)
    run.picks.append(report)
    if not report:
        run.add_failed_grasp()
    run.over_tray = bool(report) and run.options.capture_over_tray
    if report.outcome == "hand_stalled" and not _opened_again(run):
        # The hand may still hold the object, so the arm stays.
        run.stop_reason = f"the hand does not follow: {report.reason}"
        return _stop
    if report.outcome != "fault" and not run.over_tray:
        run.move_home()
    return _observe


def _opened_again(run: _Clearing) -> bool:
    """Return whether the hand has stalled only once, while closing, and is open again."""
    *earlier, last = run.picks
    again = bool(earlier) and earlier[-1].outcome == "hand_stalled"
    width = run.cell.hand.width(run.cell.reading.hand)
    closing = last.phases[-1].phase == "close"
    return closing and not again and width >= last.plan.opening - NARROW


def _stop(run: _Clearing) -> None:
    """Move home and list the remaining objects."""
    assert run.scene is not None, "the scene is valid"
    if run.over_tray:
        run.move_home()
    run.remaining = _left(run, run.selection.skipped)
    run.report_last_pick()
    if run.stop_reason == CLEAR and run.missing:
        run.remaining = (*run.remaining, run.missing)
        run.stop_reason = f"the image shows no object, but {run.missing}"
    run.stop_reason = run.cell.reading.fault or run.stop_reason


def _left(run: _Clearing, skipped: tuple[str, ...]) -> tuple[str, ...]:
    """List the objects of the last valid scene that are not in the tray, each with the reason."""
    left = {one.partition(":")[0]: one for one in skipped}
    grasp = run.grasp
    for item in () if run.scene is None else run.scene.objects:
        name, reason = f"object {item.label}", NOT_TRIED
        if grasp is not None and grasp.scene is run.scene and item.label == grasp.target.label:
            if run.picks[-1]:
                continue
            reason = run.picks[-1].outcome
        left.setdefault(name, f"{name}: {reason}")
    return tuple(left.values())


def _stop_reason(run: _Clearing) -> str:
    """Return the reason to stop before a selection; empty to continue."""
    assert run.scene is not None, "the scene is valid"
    if run.cell.reading.fault:
        return run.cell.reading.fault
    if run.picks and run.picks[-1].outcome == "touch_lost":
        return f"the hand's sense of touch failed: {run.picks[-1].reason}"
    if not run.scene.objects:
        return CLEAR
    failures = len(run.picks) - max(
        (k for k, one in enumerate(run.picks, start=1) if one), default=0
    )
    if failures >= run.options.failures:
        return f"{failures} picks failed in a row"
    if len(run.picks) >= run.options.picks:
        return f"{run.options.picks} picks made"
    return ""


def move_home(cell: Cell, scene: Scene) -> bool:
    """Move the arm to its rest posture with the hand open; return whether it got there."""
    options = cell.options
    world = CollisionWorld(
        cell.model(cell.hand.posture(cell.hand.max_opening)),
        (*scene_obstacles(scene), cell.tray.as_box(cell.tray_height)),
    )
    control = replace(options.control, dt=cell.robot.period, tolerance=HOME_TOLERANCE)
    posture = Posture(cell.home, speed=options.speed * HOME_SPEED)
    controller = PlannedApproach(world, (posture,), control, options.planner)
    command = cell.hand.opened()
    result = execute(
        cell,
        controller,
        options.time_limit(HOME_SECONDS),
        command=lambda _: command,
        stop=lambda reading: unexpected_contact(cell, reading),
    )
    return bool(result)


def _height(scene: Scene, tray: Tray) -> str:
    """Say how high the tray's floor lies above the table. An error shows a wrong camera pose."""
    if scene.support is None:
        return ""
    above = float(scene.support.normal @ tray.centre + scene.support.offset)
    return f"; the tray's floor is {1e3 * above:z.0f} mm above the table"
