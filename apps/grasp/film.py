"""A short film of the demo, encoded while the demo runs."""

from __future__ import annotations

import copy
import os
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from eyehand.data_synth.render import GlRenderer
from eyehand.data_synth.scenes import look_at
from eyehand.errors import DeviceError
from eyehand.perception import CameraIntrinsics
from eyehand.perception.io import atomic_write

from .film_frame import Caption, SidePanel, cell_size, film_frame
from .frame_crop import crop_to_objects
from .perceived_picture import perceived_picture

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import Cell, CycleInfo, GraspPlan, PickReport, SelectedGrasp

    from .demo_record import Recorder

SIZE = (960, 540)
"""Width and height of the film, px, both even as the codec requires."""
FPS = 25
"""Frames per second."""
SPEED, FINGER_SPEED = 4.0, 2.0
"""Playback speed in times real time: of the arm motion, and while the fingers close."""
FINGER_PHASES = ("contact", "close", "grip")
"""Phases in which the fingers move."""
SELECTION_SECONDS, END_SECONDS = 0.8, 1.6
"""Film time for which a selected grasp and the last image are shown, s."""
CRF = 25
"""Constant rate factor of x264. A lower value gives a sharper and larger film."""
CPU_SECONDS = 40.0
"""Processor time after which the playback speed doubles, s."""

EYE, TARGET = (0.66, 0.92, 0.82), (0.165, -0.12, 0.13)
"""Camera position and the point it looks at, world, m. The tray is in view."""
FOCAL_WIDTHS = 1.2
"""Focal length over image width. The field of view is 45° wide."""
SLICES = 28
"""Number of facets around round geoms. MuJoCo's default takes five times as long."""
SHADOW_PX = 2048
"""Side of the shadow map, px. A smaller map leaves specks on the arm."""
SAMPLES = 4
"""Samples per pixel for smooth edges."""
HEADLIGHT = 0.29
"""Diffuse light from the camera. The lamp alone leaves the near side of the hand dark."""


class CellRenderer(Protocol):
    """A renderer of the cell."""

    def picture(self) -> NDArray[np.uint8]:
        """Render the current state, (H, W, 3) uint8 RGB, in the size of `cell_size`."""
        ...

    def close(self) -> None:
        """Free the renderer."""
        ...


class Film:
    """A film that is being recorded. Use it as a context: an error discards the file.

    Parameters
    ----------
    path
        The .mp4 file.
    size
        Width and height, px.
    """

    def __init__(self, path: Path, size: tuple[int, int] = SIZE) -> None:
        self.path = path
        """The .mp4 file."""
        self._size = size
        self._resources = ExitStack()
        self._camera: CellRenderer | None = None
        self._recorder: Recorder | None = None
        self._scene_picture: NDArray[np.uint8] | None = None
        self._names: Sequence[str] = ()
        self._count_text: Callable[[], str] | None = None
        self._text, self._picks = "", 0
        self._next, self._spent, self._encoder_spent = 0.0, 0.0, 0.0
        self._writer: Any = None
        self.frames = 0
        """Number of frames written."""
        self.tray_text = ""
        """Description of the objects in the tray."""

    def __enter__(self) -> Film:
        temporary = self._resources.enter_context(atomic_write(self.path))
        self._writer = _open_writer(temporary, self._size)
        return self

    @property
    def cpu_seconds(self) -> float:
        """Processor time, s. The time of the encoder is added at the end."""
        return self._spent + self._encoder_spent

    def __exit__(self, *error: object) -> None:
        if error[0] is None and self._camera is not None:
            self._text = "finished"
            self._update_scene()
            self._update_count()
            self._show(None, None, END_SECONDS)
        before = _children_seconds()
        self._writer.close()
        self._encoder_spent = _children_seconds() - before
        if self._camera is not None:
            self._camera.close()
        self._resources.__exit__(*error)  # pyright: ignore[reportArgumentType] - as they came

    def join(self, cell: Cell, robot: SimRobot, recorder: Recorder) -> Film:
        """Start filming a cell."""

        def count() -> str:
            names = robot.object_names
            return f"{sum(map(robot.is_in_tray, names))} of {len(names)} in the tray"

        camera = FilmCamera(robot, cell_size(self._size))
        self.film(camera, recorder, (*cell.hand.fingers, "palm"), count)
        return self

    def film(
        self,
        camera: CellRenderer,
        recorder: Recorder,
        names: Sequence[str] = (),
        count: Callable[[], str] | None = None,
    ) -> None:
        """Set the camera and the data shown beside its image.

        Parameters
        ----------
        camera
            Renderer of the cell.
        recorder
            Recorder of the captures.
        names
            Names of the force sensors, in their order.
        count
            Return the description of the objects in the tray. It is called before and after
            every pick.
        """
        self._camera, self._recorder = camera, recorder
        self._names, self._count_text = names, count
        self._update_count()

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Show the selected grasp and the number of objects in the tray."""
        self._update_count()
        if report is not None:
            self._update_scene()
            self._text = f"{report.plan.name}: {report.outcome.replace('_', ' ')}"
            return
        self._picks += 1
        solid = choice.target.fit.superquadric
        size = "" if solid is None else " × ".join(f"{2e3 * a:.0f}" for a in solid.semi_axes)
        kind = solid.kind if solid else "object"
        self._text = f"pick {self._picks}: {kind} {size} mm, {choice.plan.name}"
        self._update_scene(choice.plan)
        self._show("select", None, SELECTION_SECONDS)

    def on_cycle(self, cycle: CycleInfo) -> None:
        """Take a picture when one is due, after each control cycle."""
        now = cycle.reading.time
        if now < self._next:
            return
        speed = self._speed(cycle.phase)
        self._next = now + speed / FPS
        self._show(cycle.phase, cycle.force, 1.0 / FPS)

    def _update_scene(self, plan: GraspPlan | None = None) -> None:
        """Draw the last scene and the selected grasp."""
        recorder = self._recorder
        if recorder is None or recorder.frame is None or recorder.scene is None:
            return
        began = time.process_time()
        frame, scene = crop_to_objects(recorder.frame, recorder.scene)
        self._scene_picture = perceived_picture(
            frame, scene, plan, names=False, colours=recorder.colours
        )
        self._spent += time.process_time() - began

    def _update_count(self) -> None:
        self.tray_text = self._count_text() if self._count_text is not None else ""

    def _speed(self, phase: str | None) -> float:
        """Return the playback speed, times real time."""
        speed = FINGER_SPEED if phase in FINGER_PHASES else SPEED
        return speed * 2 ** int(self._spent / CPU_SECONDS)

    def _show(self, phase: Any, force: NDArray[np.float64] | None, seconds: float) -> None:
        """Write one image for a duration of film time, s."""
        if self._camera is None:
            return
        began = time.process_time()
        caption = Caption(phase, self._text, self.tray_text, self._speed(phase))
        panel = SidePanel(self._scene_picture, self._names, force)
        picture = film_frame(self._camera.picture(), caption, panel, self._size)
        for _ in range(max(round(seconds * FPS), 1)):
            self._send(picture)
        self._spent += time.process_time() - began

    def _send(self, picture: NDArray[np.uint8]) -> None:
        try:
            self._writer.send(np.ascontiguousarray(picture))
        except OSError as error:
            raise DeviceError(f"the video {self.path} cannot be written: {error}") from error
        self.frames += 1


def _children_seconds() -> float:
    """Return the processor time of the finished child processes, s."""
    spent = os.times()
    return spent.children_user + spent.children_system


def _open_writer(path: Path, size: tuple[int, int]) -> Any:
    """Start the encoder. It is a generator to which frames are sent."""
    from imageio_ffmpeg import write_frames

    # A quality sets the bit rate. Without one, the constant rate factor applies.
    rate: dict[str, Any] = {"quality": None}
    writer = write_frames(
        str(path),
        size,
        fps=FPS,
        codec="libx264",
        macro_block_size=2,
        output_params=["-crf", str(CRF), "-preset", "veryfast", "-movflags", "+faststart"],
        ffmpeg_log_level="error",
        **rate,
    )
    writer.send(None)
    return writer


class FilmCamera:
    """A renderer of the simulated cell for the film.

    Parameters
    ----------
    robot
        The simulated robot.
    size
        Width and height of the images, px.

    Raises
    ------
    DeviceError
        If no OpenGL context can be opened.
    """

    def __init__(self, robot: SimRobot, size: tuple[int, int]) -> None:
        self._data = robot.data
        # Copy the model: its render quality must not change for the depth images.
        self._model = model = copy.copy(robot.model)
        quality = model.vis.quality
        quality.numslices, quality.numstacks = SLICES, SLICES // 2
        quality.shadowsize, quality.offsamples = SHADOW_PX, SAMPLES
        model.vis.headlight.diffuse = [HEADLIGHT] * 3
        wide, high = size
        focal = FOCAL_WIDTHS * wide
        self._intrinsics = CameraIntrinsics(
            focal, focal, (wide - 1) / 2, (high - 1) / 2, wide, high
        )
        self._T_world_camera = look_at(np.array(EYE), np.array(TARGET))
        self._renderer = GlRenderer()

    def picture(self) -> NDArray[np.uint8]:
        """Render the current state of the cell, (H, W, 3) uint8 RGB."""
        return self._renderer.photograph(
            self._model, self._data, self._intrinsics, self._T_world_camera
        )

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.close()
