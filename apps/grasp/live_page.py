"""The live page of a cell in the browser, with pause, single steps and speed."""

from __future__ import annotations

import time
from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from ..fitting.page_server import HOST, close_server, open_server
from .force_plot import force_colour
from .live_scene import CAMERA_POSITION, CAMERA_TARGET, LiveScene

if TYPE_CHECKING:
    from eyehand.data_synth.cell import SimRobot
    from eyehand.grasping import Cell, CycleInfo, GraspPlan, PickReport, SelectedGrasp

    from .demo_record import Recorder

TITLE = "eyehand demo"
UPDATE_SECONDS = 0.04
"""Wall time between two updates of the robot, s, as in a film."""
PLOT_UPDATE_SECONDS = 0.2
"""Wall time between two updates of the force plot, s."""
PLOT_SPAN = 8.0
"""Simulated time span of the force plot, s."""
STEP_SECONDS = 0.1
"""Simulated time of one step, s."""
SPEEDS = (0.1, 8.0)
"""Minimum and maximum speed, times real time."""


class LivePage:
    """A page that shows a cell during its demo. Use it as a context.

    Parameters
    ----------
    port
        Port of the page. If it is taken, the next free port is used.

    Raises
    ------
    InputError
        If no port can be opened.
    """

    def __init__(self, port: int) -> None:
        self._server = server = open_server(port, TITLE)
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.scene.set_up_direction("+z")
        server.initial_camera.position = CAMERA_POSITION
        server.initial_camera.look_at = CAMERA_TARGET
        self._scene: LiveScene | None = None
        self._recorder: Recorder | None = None
        self._phase = ""
        self._target = -1
        self._lines: list[str] = []
        self._samples: deque[tuple[float, ...]] = deque()
        self._shown = self._plotted = 0.0
        self._anchor: tuple[float, float] | None = None
        self._steps_to, self._now = -np.inf, 0.0
        self._plot: Any = None
        gui = server.gui
        self._status = gui.add_markdown("The cell is being built ...")
        with gui.add_folder("Time"):
            self.paused = gui.add_checkbox("pause", initial_value=False)
            self.step = gui.add_button(f"step {STEP_SECONDS:g} s", hint="one step, then pause")
            self.speed = gui.add_slider(
                "speed ×", min=SPEEDS[0], max=SPEEDS[1], step=0.1, initial_value=1.0
            )
        self.step.on_click(lambda _: self._step())
        self.speed.on_update(lambda _: self._set_anchor(None))
        with gui.add_folder("Show"):
            self._cloud = gui.add_checkbox("points of the depth view", initial_value=True)
            self._solids = gui.add_checkbox("fitted solids", initial_value=True)
        for box in (self._cloud, self._solids):
            box.on_update(lambda _: self._show_parts())
        self._forces = gui.add_folder("Contact forces, N")
        self._report = gui.add_markdown("")

    def __enter__(self) -> LivePage:
        return self

    def __exit__(self, *error: object) -> None:
        close_server(self._server)

    @property
    def address(self) -> str:
        """URL of the page."""
        return f"http://{HOST}:{self._server.get_port()}"

    def join(self, cell: Cell, robot: SimRobot, recorder: Recorder) -> LivePage:
        """Show a cell from now on."""
        self._recorder = recorder
        self._scene = LiveScene(self._server.scene, robot)
        names = (*cell.hand.fingers, "palm")
        self._samples.append((cell.reading.time, *(0.0 for _ in names)))
        self._add_plot(names)
        self._status.content = "Perceiving ..."
        return self

    def on_pick(self, choice: SelectedGrasp, report: PickReport | None) -> None:
        """Show the selected grasp, or the outcome of the pick."""
        if report is not None:
            outcome = report.outcome.replace("_", " ")
            outcome += f": {report.reason}" if report.reason else ""
            number = len(self._lines) + 1
            self._lines.append(f"{number}. {report.kind}, {report.plan.name}: {outcome}")
            self._report.content = "\n".join(self._lines)
            return
        self._target = choice.target.label
        self._show_scene(choice.plan)
        self._set_anchor(None)

    def on_cycle(self, cycle: CycleInfo) -> None:
        """Pause or wait to keep the speed, and update the page, after each control cycle."""
        self._wait_for(cycle.reading.time)
        self._samples.append((cycle.reading.time, *cycle.force.tolist()))
        while self._samples[-1][0] - self._samples[0][0] > PLOT_SPAN:
            self._samples.popleft()
        now = time.perf_counter()
        if now - self._shown < UPDATE_SECONDS and cycle.phase == self._phase:
            return
        self._shown = now
        self._draw(cycle)
        if now - self._plotted > PLOT_UPDATE_SECONDS:
            self._plotted = now
            self._draw_plot()

    def finish(self) -> None:
        """Show the last scene and the end of the demo."""
        self._show_scene(None)
        self._status.content = "### Done\n\nPress Ctrl-C in the terminal to end."

    def wait(self) -> None:
        """Serve until Ctrl-C."""
        while True:
            time.sleep(3600.0)

    def _show_scene(self, plan: GraspPlan | None) -> None:
        """Show the last scene and the selected grasp."""
        recorder = self._recorder
        if self._scene is None or recorder is None:
            return
        frame, scene = recorder.frame, recorder.scene
        if frame is not None and scene is not None:
            with self._server.atomic():
                self._scene.show_capture(frame, scene, plan, recorder.colours)

    def _wait_for(self, now: float) -> None:
        """Wait while the page is paused, and keep the speed of the slider."""
        while self.paused.value and now >= self._steps_to:
            self._set_anchor(None)
            time.sleep(UPDATE_SECONDS / 2)
        self._now = now
        if self._anchor is None:
            self._set_anchor((time.perf_counter(), now))
        assert self._anchor is not None
        due = self._anchor[0] + (now - self._anchor[1]) / float(self.speed.value)
        ahead = due - time.perf_counter()
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -UPDATE_SECONDS:
            # The computer is too slow for this speed. Do not catch up.
            self._set_anchor((time.perf_counter(), now))

    def _step(self) -> None:
        self.paused.value = True
        self._steps_to = self._now + STEP_SECONDS

    def _set_anchor(self, anchor: tuple[float, float] | None) -> None:
        self._anchor = anchor

    def _draw(self, cycle: CycleInfo) -> None:
        with self._server.atomic():
            if self._scene is not None:
                self._scene.move()
                if cycle.phase == "lift" != self._phase:
                    self._scene.remove_object(self._target)
            if cycle.phase != self._phase:
                plan = cycle.plan
                tasks = [] if plan is None else [f"- {task.description}" for task in plan.tasks]
                name = "" if plan is None else f", {plan.name}"
                self._status.content = "\n".join([f"### {cycle.phase}{name}", "", *tasks])
        self._phase = cycle.phase

    def _show_parts(self) -> None:
        if self._scene is not None:
            self._scene.show(cloud=self._cloud.value, solids=self._solids.value)

    def _add_plot(self, names: tuple[str, ...]) -> None:
        from viser import uplot

        series = [uplot.Series(label="s")]
        for number, name in enumerate(names):
            colour = force_colour(number, len(names))
            series.append(uplot.Series(label=name, stroke=colour, width=2))
        with self._forces:
            self._plot = self._server.gui.add_uplot(
                self._columns(), tuple(series), scales={"x": uplot.Scale(time=False)}, aspect=1.6
            )

    def _columns(self) -> tuple[np.ndarray, ...]:
        return tuple(np.array(self._samples, dtype=np.float64).T.copy())

    def _draw_plot(self) -> None:
        if self._plot is not None:
            self._plot.data = self._columns()
