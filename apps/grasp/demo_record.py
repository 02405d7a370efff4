"""What a demo remembers of clearing a table: every look with what was chosen and felt after it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from .object_colours import colour_numbers

if TYPE_CHECKING:
    from pathlib import Path

    from scipy.spatial.transform import RigidTransform

    from eyehand.grasping import Cell, ClearReport, CycleInfo, PickReport, SelectedGrasp
    from eyehand.perception import DepthFrame, Scene, SceneObject

    from .bench.trial import PickRow, TrialResult


@dataclass(frozen=True)
class Look:
    """One depth image, what was seen in it, and the pick that followed."""

    frame: DepthFrame
    """The depth image."""
    scene: Scene
    """What was seen, without what lies in the tray."""
    pick: PickReport | None
    """What was done then; None where nothing was."""
    row: PickRow | None
    """The same pick held against the simulation's truth."""
    T_world_palm: RigidTransform | None
    """Where the palm was when the hand began to close; None where it did not come so far."""
    colours: dict[int, int] = field(default_factory=dict)
    """Number of each object's colour by its label: an object keeps it from look to look."""

    @property
    def went_well(self) -> bool:
        """Whether it was placed, and lies in the tray by the simulation's truth."""
        return bool(self.pick) and (self.row is None or self.row.success)

    @property
    def outcome(self) -> str:
        """How the pick ended, in words: what the robot says, and what the truth says against it."""
        if self.pick is None:
            return ""
        told = self.pick.outcome.replace("_", " ")
        return f"{told} (not in the tray)" if self.pick and not self.went_well else told

    @property
    def target(self) -> SceneObject | None:
        """The object that was picked."""
        if self.pick is None:
            return None
        label = self.pick.label
        return next((one for one in self.scene.objects if one.label == label), None)


@dataclass(frozen=True)
class DemoRecord:
    """A table cleared, from the first look to the last."""

    source: str
    """What was on the table, in words."""
    looks: tuple[Look, ...]
    """Every look, in order."""
    report: ClearReport
    """What was done, as the robot tells it."""
    result: TrialResult
    """The same by the simulation's truth."""
    fingers: tuple[str, ...]
    """Names of the fingers, in the order of the forces; the palm comes after them."""
    film: Path | None = None
    """The video, where there is one."""
    film_cpu_seconds: float | None = None
    """Processor time that it took, s."""


class Recorder:
    """Remembers every look of a cell, every pick, and where the hand was when it closed.

    Parameters
    ----------
    cell
        The cell; what it sees by is replaced by what also remembers.
    """

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._seen: list[tuple[DepthFrame, Scene]] = []
        self._picks: dict[int, PickReport] = {}
        self._palms: dict[int, RigidTransform] = {}
        self._chosen_by = 0
        perceive = cell.perceive

        def remember(frame: DepthFrame) -> Scene:
            scene = perceive(frame)
            self._seen.append((frame, scene))
            return scene

        cell.perceive = remember

    @property
    def frame(self) -> DepthFrame | None:
        """The last depth image."""
        return self._seen[-1][0] if self._seen else None

    @property
    def scene(self) -> Scene | None:
        """What was seen in it, without what lies in the tray."""
        return self._on_table(self._seen[-1][1]) if self._seen else None

    @property
    def colours(self) -> dict[int, int]:
        """Number of each of its objects' colour, by label."""
        return self._all_colours()[-1] if self._seen else {}

    def on_cycle(self, cycle: CycleInfo) -> None:
        """Note where the palm is when the hand begins to close, after each control cycle."""
        number = len(self._seen) - 1
        if cycle.phase == "close" and number not in self._palms:
            self._palms[number] = self._cell.palm_pose()

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Take note of a pick that ended, with the look that it was chosen by."""
        del choice
        if report is None:
            self._chosen_by = len(self._seen) - 1
        else:
            self._picks[self._chosen_by] = report

    def looks(self, rows: tuple[PickRow, ...]) -> tuple[Look, ...]:
        """Give all looks, each with its pick and the pick's row of truth, in order."""
        made: list[Look] = []
        truth = iter(rows)
        colours = self._all_colours()
        for number, (frame, seen) in enumerate(self._seen):
            scene = self._on_table(seen)
            pick = self._picks.get(number)
            row = None if pick is None else next(truth, None)
            palm = self._palms.get(number)
            made.append(Look(frame, scene, pick, row, palm, colours[number]))
        return tuple(made)

    def _on_table(self, scene: Scene) -> Scene:
        contains = self._cell.tray.contains
        objects = tuple(one for one in scene.objects if not contains(one.points.mean(axis=0)))
        return replace(scene, objects=objects)

    def _all_colours(self) -> tuple[dict[int, int], ...]:
        looks = [self._on_table(scene).objects for _, scene in self._seen]
        taken = {number: pick.label for number, pick in self._picks.items() if pick}
        return colour_numbers(looks, taken)
