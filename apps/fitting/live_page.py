"""The live page of fits: a browser shows cloud and solid, with a slider per number."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..scene_json import fit_parts
from .page_scene import PageScene, starting_camera
from .page_server import HOST, close_server, open_server
from .solid_numbers import numbers_of, solid_numbers, solid_of
from .solid_text import shape_text, size_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .fit_inputs import FittedCloud

TITLE = "eyehand fit"
MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""
WITHIN_PCT = 90.0
GROUPS = {"size": "Size", "shape": "Shape", "turn": "Turn", "move": "Move"}


class LivePage:
    """A web page that shows fits until it is closed.

    Parameters
    ----------
    fits
        Fits to show, at least one. A list on the page selects one of them.
    port
        Port of the server. If it is in use, the next free port is taken.

    Raises
    ------
    InputError
        If no port can be opened.
    """

    def __init__(self, fits: Sequence[FittedCloud], port: int) -> None:
        self._fits = list(fits)
        self._server = open_server(port, TITLE)
        self._lock = threading.RLock()
        self._loading = False
        self._controls: list[Any] = []
        self.sliders: dict[str, Any] = {}
        """Name of a number (a1 ... k2) → slider."""
        self.kind_buttons: dict[str, Any] = {}
        """Text of a candidate → button."""
        self.part: Any = None
        """List that selects the solid for the sliders; None if there is only one."""
        self._server.gui.configure_theme(show_logo=False, show_share_button=False)
        self._server.gui.main_panel.dock_right()
        self._add_permanent_controls()
        self._select(0)

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self._server.get_port()}"

    @property
    def solids(self) -> tuple[Superquadric, ...]:
        """The solids shown now, in the frame of the cloud."""
        return tuple(self._parts)

    @property
    def residuals(self) -> NDArray[np.float64]:
        """Signed distances of the shown points from the shown solids, (N,), m."""
        return self._residuals

    def select(self, name: str) -> None:
        """Show another cloud by its name in the list."""
        self._choice.value = name

    def wait(self) -> None:
        """Serve until Ctrl-C."""
        try:
            while True:
                time.sleep(3600.0)
        except KeyboardInterrupt:
            pass
        finally:
            self.close()

    def close(self) -> None:
        """Stop serving."""
        close_server(self._server)

    def _add_permanent_controls(self) -> None:
        gui = self._server.gui
        names = [Path(fitted.cloud.name).name for fitted in self._fits]
        # Files with the same name need different entries in the list.
        self._names = [
            name if names.count(name) == 1 else f"{number}. {name}"
            for number, name in enumerate(names, start=1)
        ]
        self._choice = gui.add_dropdown("cloud", self._names, visible=len(names) > 1)
        self._choice.on_update(lambda _: self._select(self._names.index(self._choice.value)))
        self._summary = gui.add_markdown("")
        with gui.add_folder("Show"):
            self._show_cloud = gui.add_checkbox("points", initial_value=True)
            self._show_solid = gui.add_checkbox("solid", initial_value=True)
        for box in (self._show_cloud, self._show_solid):
            box.on_update(lambda _: self._redraw())

    def _select(self, number: int) -> None:
        with self._lock:
            for control in reversed(self._controls):
                control.remove()
            self._controls, self.sliders, self.kind_buttons, self.part = [], {}, {}, None
            if hasattr(self, "_page_scene"):
                self._page_scene.remove()
            self._fitted = self._fits[number]
            self._parts = list(fit_parts(self._fitted.fit))
            self._page_scene = PageScene(self._server.scene, "/fit", self._fitted.cloud)
            self._limit = self._page_scene.limit_mm(self._parts)
            self._edited = 0
            position, up = starting_camera(self._fitted.cloud)
            self._server.scene.set_up_direction(tuple(up))
            self._server.initial_camera.position = tuple(position)
            self._server.initial_camera.look_at = (0.0, 0.0, 0.0)
            for client in self._server.get_clients().values():
                client.camera.position = tuple(position)
                client.camera.look_at = (0.0, 0.0, 0.0)
            if self._parts:
                self._add_candidate_folder()
                self._add_sliders()
                self._load(self._parts[0])
            else:
                self._redraw()

    def _add_candidate_folder(self) -> None:
        gui, fit = self._server.gui, self._fitted.fit
        folder = gui.add_folder("Solids tried")
        self._controls.append(folder)
        with folder:
            if len(self._parts) > 1:
                choices = [f"part {k + 1}: {part.kind}" for k, part in enumerate(self._parts)]
                self.part = gui.add_dropdown("edit", choices)
                self.part.on_update(lambda _: self._edit(choices.index(self.part.value)))
                self._add_candidate_button("as fitted", None)
                return
            for candidate in fit.candidates:
                behind = candidate.criterion - fit.candidates[0].criterion
                text = f"{candidate.kind}: {candidate.spread * 1e3:.2f} mm, +{behind:.1f}"
                self._add_candidate_button(text, candidate.superquadric)
            for candidate in fit.alternatives:
                if candidate not in fit.candidates:
                    text = f"as likely: {candidate.kind}, {size_text(candidate.superquadric)}"
                    self._add_candidate_button(text, candidate.superquadric)

    def _add_candidate_button(self, text: str, solid: Superquadric | None) -> None:
        hint = "spread of the points, and difference of its criterion (BIC) from the best"
        button = self._server.gui.add_button(text, hint=hint)
        button.on_click(lambda _: self._reset() if solid is None else self._load(solid))
        self.kind_buttons[text] = button

    def _add_sliders(self) -> None:
        gui = self._server.gui
        extent = max(2e3 * float(part.semi_axes.max()) for part in self._parts)
        numbers = solid_numbers(max(extent, 1e3 * self._page_scene.reach))
        for group, title in GROUPS.items():
            folder = gui.add_folder(title)
            self._controls.append(folder)
            with folder:
                for number in numbers:
                    if number.group != group:
                        continue
                    slider = gui.add_slider(
                        number.label,
                        min=number.low,
                        max=number.high,
                        step=number.step,
                        initial_value=max(number.low, 0.0),
                    )
                    slider.on_update(lambda _: self._on_slider())
                    self.sliders[number.name] = slider

    def _edit(self, part: int) -> None:
        with self._lock:
            self._edited = part
            self._load(self._parts[part])

    def _reset(self) -> None:
        with self._lock:
            self._parts = list(fit_parts(self._fitted.fit))
            self._load(self._parts[self._edited])

    def _load(self, solid: Superquadric) -> None:
        """Replace the edited solid, and set the sliders to its numbers."""
        with self._lock:
            self._loading = True
            try:
                for name, value in numbers_of(solid).items():
                    self.sliders[name].value = value
            finally:
                self._loading = False
            self._start = self._parts[self._edited] = solid
            self._redraw()

    def _on_slider(self) -> None:
        if self._loading:
            return
        with self._lock:
            numbers = {name: slider.value for name, slider in self.sliders.items()}
            self._parts[self._edited] = solid_of(numbers, self._start)
            self._redraw()

    def _redraw(self) -> None:
        with self._lock, self._server.atomic():
            self._residuals = self._page_scene.draw(self._parts, self._limit)
            self._page_scene.show(cloud=self._show_cloud.value, solid=self._show_solid.value)
            self._summary.content = self._text()

    def _text(self) -> str:
        fit, cloud = self._fitted.fit, self._fitted.cloud
        if not self._parts:
            return f"**no solid** for {cloud.name}: {fit.reason}"
        solid = self._parts[self._edited]
        distances = np.abs(self._residuals) * 1e3
        lines = [
            f"### {solid.kind}",
            f"{size_text(solid)}, {shape_text(solid)}",
            "",
            "| points | now | fit |",
            "| --- | --- | --- |",
            *(
                f"| {what} | {now:.2f} mm | {then:.2f} mm |"
                for what, now, then in zip(
                    ("spread (σ)", f"{WITHIN_PCT:.0f} % within", "farthest"),
                    _figures(distances),
                    _figures(self._fit_distances_mm()),
                    strict=True,
                )
            ),
            "",
            f"Colours: blue inside, red outside, full at {self._limit:g} mm.",
        ]
        if fit.reason:
            lines.append(f"\n**Cannot be used:** {fit.reason}")
        return "\n".join(lines)

    def _fit_distances_mm(self) -> NDArray[np.float64]:
        from .picture_scene import residual_to

        _, residuals = residual_to(self._page_scene.points, fit_parts(self._fitted.fit))
        return np.abs(residuals) * 1e3


def _figures(distances_mm: NDArray[np.float64]) -> tuple[float, float, float]:
    return (
        MAD_TO_SIGMA * float(np.median(distances_mm)),
        float(np.percentile(distances_mm, WITHIN_PCT)),
        float(distances_mm.max()),
    )
