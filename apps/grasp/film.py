"""A short film of a table being cleared, written while it happens."""

from __future__ import annotations

import os
import time
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from eyehand.errors import DeviceError, InputError
from eyehand.perception.io import atomic_write

from .film_frame import Aside, Caption, film_frame, stage_size
from .frame_crop import closeup
from .perceived_picture import look_picture

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import Cell, CycleInfo, GraspPlan, PickReport, SelectedGrasp

    from .demo_record import Recorder

HANDS_ON = ("contact", "close", "grip")
"""Phases in which the fingers move: they are shown slower."""


@dataclass(frozen=True)
class FilmOptions:
    """How a film is made.

    Raises
    ------
    InputError
        If a value is not positive, or a side of the picture is odd.
    """

    size: tuple[int, int] = (960, 540)
    """Width and height, px, both even: larger takes longer to encode."""
    fps: int = 25
    """Pictures per second."""
    pace: float = 4.0
    """Times real time on the way: faster is shorter and cheaper to make."""
    hands_on_pace: float = 2.0
    """Times real time while the fingers close."""
    still_seconds: float = 0.8
    """How long what was chosen is shown before the hand moves, s of film."""
    end_seconds: float = 1.6
    """How long the last picture stays, s of film."""
    crf: int = 25
    """Constant rate factor of x264: lower is sharper and larger."""
    cpu_seconds: float = 40.0
    """Processor time after which the film goes twice as fast, s."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not np.min(value) > 0:
                raise InputError(f"film option {name} must be > 0, got {value}")
        if any(side % 2 for side in self.size):
            raise InputError(f"a film's width and height must be even, got {self.size}")


class Camera(Protocol):
    """Who photographs the cell."""

    def picture(self) -> NDArray[np.uint8]:
        """Photograph it as it is now, (H, W, 3) uint8 RGB, as large as the film's stage."""
        ...

    def close(self) -> None:
        """Free what draws."""
        ...


class Film:
    """A film under way; a context, whose end writes the file whole or, by an error, not at all.

    Parameters
    ----------
    path
        The .mp4 file.
    options
        How it is made.
    """

    def __init__(self, path: Path, options: FilmOptions | None = None) -> None:
        self.path = path
        """Where it is written."""
        self._options = options or FilmOptions()
        self._held = ExitStack()
        self._camera: Camera | None = None
        self._recorder: Recorder | None = None
        self._seen: NDArray[np.uint8] | None = None
        self._names: Sequence[str] = ()
        self._count: Callable[[], str] | None = None
        self._told, self._picks = "", 0
        self._next, self._spent, self._encoder_spent = 0.0, 0.0, 0.0
        self._writer: Any = None
        self.frames = 0
        """Pictures so far."""
        self.counted = ""
        """What lies in the tray, in words."""

    def __enter__(self) -> Film:
        temporary = self._held.enter_context(atomic_write(self.path))
        self._writer = _open_writer(temporary, self._options)
        return self

    @property
    def cpu_seconds(self) -> float:
        """Processor time so far, s; that of the encoder comes with the end."""
        return self._spent + self._encoder_spent

    def __exit__(self, *error: object) -> None:
        if error[0] is None and self._camera is not None:
            self._told = "nothing more to do here"
            self._see_again()
            self._count_again()
            self._show(None, None, self._options.end_seconds)
        before = _children_seconds()
        self._writer.close()
        self._encoder_spent = _children_seconds() - before
        if self._camera is not None:
            self._camera.close()
        self._held.__exit__(*error)  # pyright: ignore[reportArgumentType] - as they came

    def join(self, cell: Cell, robot: SimRobot, recorder: Recorder) -> Film:
        """Set up the camera in a cell."""
        from .film_camera import StageCamera

        def count() -> str:
            names = robot.object_names
            return f"{sum(map(robot.in_tray, names))} of {len(names)} in the tray"

        camera = StageCamera(robot, stage_size(self._options.size))
        self.film(camera, recorder, (*cell.robot.hand.fingers, "palm"), count)
        return self

    def film(
        self,
        camera: Camera,
        recorder: Recorder,
        names: Sequence[str] = (),
        count: Callable[[], str] | None = None,
    ) -> None:
        """Film by a camera.

        Parameters
        ----------
        camera
            Who photographs the cell.
        recorder
            Who knows what was seen.
        names
            Of what feels forces, in their order.
        count
            Tells in words what truly lies in the tray; asked before and after every pick.
        """
        self._camera, self._recorder = camera, recorder
        self._names, self._count = names, count
        self._count_again()

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Show what was chosen; count what lies in the tray."""
        self._count_again()
        if report is not None:
            self._see_again()
            self._told = f"{report.plan.name}: {report.outcome.replace('_', ' ')}"
            return
        self._picks += 1
        solid = choice.target.fit.superquadric
        size = "" if solid is None else " × ".join(f"{2e3 * a:.0f}" for a in solid.semi_axes)
        kind = solid.kind if solid else "object"
        self._told = f"pick {self._picks}: {kind} {size} mm, {choice.plan.name}"
        self._see_again(choice.plan)
        self._show("select", None, self._options.still_seconds)

    def on_cycle(self, cycle: CycleInfo) -> None:
        """Take a picture when one is due, after each control cycle."""
        now = cycle.reading.time
        if now < self._next:
            return
        pace = self._pace(cycle.phase)
        self._next = now + pace / self._options.fps
        self._show(cycle.phase, cycle.force, 1.0 / self._options.fps)

    def _see_again(self, plan: GraspPlan | None = None) -> None:
        """Show the last look, and the grasp to come."""
        recorder = self._recorder
        if recorder is None or recorder.frame is None or recorder.scene is None:
            return
        began = time.process_time()
        frame, scene = closeup(recorder.frame, recorder.scene)
        self._seen = look_picture(frame, scene, plan, names=False, colours=recorder.colours)
        self._spent += time.process_time() - began

    def _count_again(self) -> None:
        self.counted = self._count() if self._count is not None else ""

    def _pace(self, phase: str | None) -> float:
        options = self._options
        pace = options.hands_on_pace if phase in HANDS_ON else options.pace
        return pace * 2 ** int(self._spent / options.cpu_seconds)

    def _show(self, phase: Any, force: NDArray[np.float64] | None, seconds: float) -> None:
        """Write one picture, for some seconds of film."""
        if self._camera is None:
            return
        began = time.process_time()
        caption = Caption(phase, self._told, self.counted, self._pace(phase))
        aside = Aside(self._seen, self._names, force)
        picture = film_frame(self._camera.picture(), caption, aside, self._options.size)
        for _ in range(max(round(seconds * self._options.fps), 1)):
            self._send(picture)
        self._spent += time.process_time() - began

    def _send(self, picture: NDArray[np.uint8]) -> None:
        try:
            self._writer.send(np.ascontiguousarray(picture))
        except OSError as error:
            raise DeviceError(f"the video {self.path} cannot be written: {error}") from error
        self.frames += 1


def _children_seconds() -> float:
    """Processor time of this process's children that ended, s."""
    spent = os.times()
    return spent.children_user + spent.children_system


def _open_writer(path: Path, options: FilmOptions) -> Any:
    """Start the encoder: a generator that takes pictures."""
    from imageio_ffmpeg import write_frames

    # Without a quality of its own, which is a bit rate, the constant rate factor holds.
    rate: dict[str, Any] = {"quality": None}
    writer = write_frames(
        str(path),
        options.size,
        fps=options.fps,
        codec="libx264",
        macro_block_size=2,
        output_params=["-crf", str(options.crf), "-preset", "veryfast", "-movflags", "+faststart"],
        ffmpeg_log_level="error",
        **rate,
    )
    writer.send(None)
    return writer
