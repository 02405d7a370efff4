"""The record of a demo: every capture with its scene and the pick that followed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from .object_colours import colour_numbers

if TYPE_CHECKING:
    from pathlib import Path

    from scipy.spatial.transform import RigidTransform

    from eyehand.grasping import Cell, ClearReport, CycleInfo, PickReport, SelectedGrasp
    from eyehand.perception import DepthFrame, Scene, SceneObject

    from .bench.pick_row import PickRow
    from .bench.trial import TrialResult


@dataclass(frozen=True)
class Capture:
    """A depth image, its scene, and the pick that followed."""

    frame: DepthFrame
    """The depth image."""
    scene: Scene
    """The perceived scene, without the objects in the tray."""
    pick: PickReport | None
    """The pick that followed, or None."""
    row: PickRow | None
    """The same pick, scored against the ground truth."""
    T_world_palm: RigidTransform | None
    """Pose of the palm when the hand began to close; None if it did not."""
    colours: dict[int, int] = field(default_factory=dict)
    """Colour number of each object by its label. An object keeps its number over all captures."""

    @property
    def succeeded(self) -> bool:
        """Whether the robot reports success and the object is in the tray."""
        return bool(self.pick) and (self.row is None or self.row.success)

    @property
    def outcome(self) -> str:
        """Outcome reported by the robot, with a note if the object is not in the tray."""
        if self.pick is None:
            return ""
        outcome = self.pick.outcome.replace("_", " ")
        return f"{outcome} (not in the tray)" if self.pick and not self.succeeded else outcome

    @property
    def target(self) -> SceneObject | None:
        """The object that was picked."""
        if self.pick is None:
            return None
        label = self.pick.label
        return next((item for item in self.scene.objects if item.label == label), None)


@dataclass(frozen=True)
class DemoRecord:
    """The record of a demo."""

    source: str
    """Description of the scene for people."""
    captures: tuple[Capture, ...]
    """All captures, in order."""
    report: ClearReport
    """Report of the robot."""
    result: TrialResult
    """Result scored against the ground truth."""
    fingers: tuple[str, ...]
    """Names of the fingers, in the order of the forces. The palm comes after them."""
    film: Path | None = None
    """The video file, or None."""
    film_cpu_seconds: float | None = None
    """Processor time of the film, s."""


class Recorder:
    """A recorder of the captures, picks and closing palm poses of a cell.

    Parameters
    ----------
    cell
        The cell. Its `perceive` callback is wrapped.
    """

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._perceived: list[tuple[DepthFrame, Scene]] = []
        self._picks: dict[int, PickReport] = {}
        self._palms: dict[int, RigidTransform] = {}
        self._pick_capture = 0
        perceive = cell.perceive

        def perceive_and_record(frame: DepthFrame) -> Scene:
            scene = perceive(frame)
            self._perceived.append((frame, scene))
            return scene

        cell.perceive = perceive_and_record

    @property
    def frame(self) -> DepthFrame | None:
        """The last depth image."""
        return self._perceived[-1][0] if self._perceived else None

    @property
    def scene(self) -> Scene | None:
        """The last scene, without the objects in the tray."""
        return self._on_table(self._perceived[-1][1]) if self._perceived else None

    @property
    def colours(self) -> dict[int, int]:
        """Colour number of each object in the last scene, by label."""
        return self._all_colours()[-1] if self._perceived else {}

    def on_cycle(self, cycle: CycleInfo) -> None:
        """Record the palm pose in the first cycle in which the hand closes."""
        index = len(self._perceived) - 1
        if cycle.phase == "close" and index not in self._palms:
            self._palms[index] = self._cell.palm_pose()

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Record a finished pick, with the capture from which it was selected."""
        del choice
        if report is None:
            self._pick_capture = len(self._perceived) - 1
        else:
            self._picks[self._pick_capture] = report

    def captures(self, rows: tuple[PickRow, ...]) -> tuple[Capture, ...]:
        """Return all captures in order, each with its pick and the scored row of the pick."""
        captures: list[Capture] = []
        remaining_rows = iter(rows)
        colours = self._all_colours()
        for index, (frame, scene) in enumerate(self._perceived):
            pick, palm = self._picks.get(index), self._palms.get(index)
            row = None if pick is None else next(remaining_rows, None)
            on_table = self._on_table(scene)
            captures.append(Capture(frame, on_table, pick, row, palm, colours[index]))
        return tuple(captures)

    def _on_table(self, scene: Scene) -> Scene:
        contains = self._cell.tray.contains
        objects = tuple(item for item in scene.objects if not contains(item.points.mean(axis=0)))
        return replace(scene, objects=objects)

    def _all_colours(self) -> tuple[dict[int, int], ...]:
        objects = [self._on_table(scene).objects for _, scene in self._perceived]
        removed = {index: pick.label for index, pick in self._picks.items() if pick}
        return colour_numbers(objects, removed)
