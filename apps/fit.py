"""`eyehand fit`: fit the simplest solid to point clouds, meshes and objects of depth frames."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from rich.markup import escape
from rich.table import Table

from eyehand.errors import InputError
from eyehand.perception import FitOptions, SuperquadricFit
from eyehand.perception.superquadric import MAX_PARTS, Kind, OptimiserName

from .console import print_json, say, show, tracked
from .fitting.fit_inputs import CloudInput, FittedCloud, FrameInput, read_inputs
from .fitting.robot_files import WATER_DENSITY
from .frame_masks import FrameMasks
from .mesh_file import MeshFormat
from .output_files import make_folder
from .perceived_frame import load_kernels
from .scene_json import fit_json, fit_parts

DEFAULT_PORT = 8080

KindChoice = Literal["auto"] | Kind
"""A kind of solid; ``auto`` selects the simplest kind that explains the points."""
MAX_NOISE_MM = 100.0
"""Maximum noise, mm."""
MAX_BEYOND = 0.01
"""Distance beyond a mesh, or before its end, from which the size of a solid is wrong, m."""


def fit_command(
    *clouds: Annotated[Path, Parameter(json_list=False)],
    label: Annotated[tuple[int, ...], Parameter(consume_multiple=False)] = (),
    camera: Path | None = None,
    masks: Annotated[FrameMasks | None, Parameter(name="*", group="Masks")] = None,
    view_origin: tuple[float, float, float] | None = None,
    plane: tuple[float, float, float, float] | None = None,
    kind: KindChoice = "auto",
    noise_mm: float = 1.5,
    budget_ms: float | None = None,
    max_parts: int | None = None,
    points: int | None = None,
    optimiser: OptimiserName | None = None,
    out: Path | None = None,
    mesh: MeshFormat = "ply",
    density: float = WATER_DENSITY,
    view: bool = False,
    port: int = DEFAULT_PORT,
    page: Path | None = None,
    json: bool = False,
) -> int:
    """Fit the simplest solid that explains the points to each cloud.

    Parameters
    ----------
    clouds
        Point clouds (.ply, .pcd, .npz, .xyz, .txt, .csv) or meshes (.obj, .stl) in metres, or depth
        frames (.png, .npz, organised .pcd or .ply) with --label. A solid ends where a closed mesh
        ends.
    label
        Label of an object in the segmentation of a depth frame. It may be repeated. Camera and
        support plane come from the frame. 0 takes all readings as one cloud.
    camera
        Camera file of depth frames; default: <frame>.json or camera.json beside the frame.
    masks
        Readings of a depth frame that are no objects.
    view_origin
        Camera position in the frame of the cloud, m. It shows which space was seen to be free.
    plane
        Support plane a b c d with a x + b y + c z + d = 0, with the normal towards the object.
    kind
        Kind of solid. auto selects the simplest one that explains the points.
    noise_mm
        Expected standard deviation of the points, mm.
    budget_ms
        Median time of a fit of one solid, ms; objects of several parts take longer. The most
        accurate stored setting within it is used.
    max_parts
        Maximum number of solids per object, where one solid does not explain it. Default: 4,
        or that of the stored setting.
    points
        Number of points used. More points are more accurate and slower.
    optimiser
        Optimiser of the final refinement. lm is the fastest.
    out
        Output folder: <name>_solid.json, .png and mesh, <name>_body.xml (MJCF) and .urdf.
    mesh
        Format of the solid's mesh.
    density
        Density of the solid in the MJCF and URDF files, kg/m³.
    view
        Show clouds and solids on a live page. Ctrl-C ends it.
    port
        Port of the live page. If it is taken, the next free port is used.
    page
        Write a self-contained .html page that shows clouds and solids.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if not clouds:
        raise InputError("give at least one cloud: eyehand fit CLOUD [CLOUD ...]")
    choice = FitChoice(kind, noise_mm, budget_ms, max_parts, points, optimiser)
    options = choice.options()
    _check_outputs(density, port, page)
    if view_origin is not None and not np.all(np.isfinite(view_origin)):
        raise InputError(f"--view-origin needs 3 finite numbers, got {view_origin}")
    inputs = read_inputs(
        clouds,
        labels=label,
        camera=camera,
        masks=masks,
        view_origin=view_origin,
        support_plane=_unit(plane),
    )
    if out is not None:
        _check_names(inputs)
        make_folder(out)
    if page is not None:
        make_folder(page.parent)
    load_kernels()
    fits = [
        fitted
        for item in tracked(inputs, "fitting", len(inputs))
        for fitted in item.fitted(options)
    ]
    if out is not None:
        _write(out, fits, mesh, density)
    if page is not None:
        from .fitting.solid_page import write_page

        write_page(page, fits)
        say(f"page written to {page}")
    show(_table(fits), json_wanted=json)
    if json:
        print_json("fit", options.seed, [_row(fitted) for fitted in fits])
    if view:
        _serve(fits, port)
    return 0 if all(fitted.fit for fitted in fits) else 1


def _check_outputs(density: float, port: int, page: Path | None) -> None:
    if not 0.0 < density < float("inf"):
        raise InputError(f"--density must be finite and above 0 kg/m³, got {density}")
    if not 1 <= port <= 65535:
        raise InputError(f"--port must be 1 to 65535, got {port}")
    if page is not None and page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--page must name an .html file, got {page}")
    if page is not None and page.exists() and not page.is_file():
        raise InputError(f"--page must name a file, but {page} is a folder, FIFO or device")


def _unit(plane: Sequence[float] | None) -> np.ndarray | None:
    if plane is None:
        return None
    length = float(np.linalg.norm(plane[:3]))
    if not np.all(np.isfinite(plane)) or not length > 0:
        raise InputError(f"--plane needs 4 finite numbers and a non-zero normal, got {plane}")
    return np.asarray(plane, dtype=np.float64) / length


def _check_names(inputs: Sequence[CloudInput | FrameInput]) -> None:
    """Reject clouds whose output files would have the same name."""
    stems = [stem for item in inputs for stem in item.stems]
    twice = sorted({stem for stem in stems if stems.count(stem) > 1})
    if twice:
        raise InputError(
            f"clouds with the same name ({', '.join(twice)}) need a separate --out folder each"
        )


def _write(folder: Path, fits: Sequence[FittedCloud], mesh: MeshFormat, density: float) -> None:
    from .fitting.solid_files import solid_files, write_files

    for fitted in tracked(fits, "drawing and writing", len(fits)):
        write_files(folder, solid_files(fitted, form=mesh, density=density))
    say(f"solids written to {folder}")


def _serve(fits: Sequence[FittedCloud], port: int) -> None:
    from .fitting.solid_page import served_page

    # Ctrl-C may come as soon as the address is printed.
    with served_page(fits, port) as address, suppress(KeyboardInterrupt):
        say(f"live page at {address} - Ctrl-C ends it")
        Event().wait()
    say("page closed")


def _row(fitted: FittedCloud) -> dict[str, Any]:
    fit = fitted.fit
    report, beyond = fit_json(fit), fitted.beyond_mesh
    return {
        "name": fitted.cloud.name,
        "converged": fit.converged,
        "reason": fit.reason,
        "spread_mm": None if report["spread_m"] is None else round(fit.spread * 1e3, 3),
        "fit_ms": round(fit.seconds * 1e3, 2),
        **{key: report[key] for key in _ROW_KEYS},
        "beyond_mesh_mm": None if beyond is None else round(1e3 * beyond, 1),
        "runner_up": None if report["runner_up"] is None else report["runner_up"]["kind"],
    }


_ROW_KEYS = ("solid", "parts", "uncertainty", "sides", "margin", "ambiguous")


def _table(fits: Sequence[FittedCloud]) -> Table:
    title = "1 cloud" if len(fits) == 1 else f"{len(fits)} clouds"
    table = Table(title=title, title_justify="left")
    for column in ("cloud", "solid", "size mm", "± mm", "ε1 ε2", "centre mm", "spread mm", "ms"):
        table.add_column(column)
    table.add_column("note", overflow="fold")
    for fitted in fits:
        fit, name = fitted.fit, escape(Path(fitted.cloud.name).name)
        if fit.superquadric is None:
            table.add_row(name, "none", "-", "-", "-", "-", "-", "-", fit.reason)
            continue
        parts = fit_parts(fit)
        for number, solid in enumerate(parts):
            table.add_row(
                name if number == 0 else "",
                solid.kind,
                " x ".join(f"{2e3 * a:.1f}" for a in solid.semi_axes),
                _deviations(fit) if number == 0 else "",
                f"{solid.exponents[0]:.2f} {solid.exponents[1]:.2f}",
                " ".join(f"{round(1e3 * x, 1) + 0.0:.1f}" for x in solid.centre),
                f"{fit.spread * 1e3:.2f}" if number == 0 else "",
                f"{fit.seconds * 1e3:.0f}" if number == 0 else "",
                _note(fitted) if number == 0 else f"part {number + 1}",
            )
    return table


def _deviations(fit: SuperquadricFit) -> str:
    """Return the standard deviations of the object's widths along the axes of its solid, mm."""
    solid = fit.superquadric
    if solid is None:
        return "-"
    widths = [fit.width(axis) for axis in solid.rotation.T]
    return " ".join(f"{1e3 * width.sigma:.1f}" for width in widths if width is not None)


def _note(fitted: FittedCloud) -> str:
    """Return the remark on a fit: failure, other kinds, unseen sides, taper."""
    fit = fitted.fit
    if fit.reason:
        return fit.reason
    notes = []
    if fit.ambiguous:
        kinds = dict.fromkeys(candidate.kind for candidate in fit.alternatives)
        notes.append(f"or {', '.join(kinds)}")
    if fit.width_uncertain:
        notes.append("width uncertain")
    if fit.uncertainty is not None and fit.uncertainty.unobserved:
        notes.append(f"not seen: {' '.join(fit.uncertainty.unobserved)}")
    beyond = fitted.beyond_mesh
    if beyond is not None and abs(beyond) > MAX_BEYOND:
        end = "reaches {:.0f} mm beyond" if beyond > 0.0 else "ends {:.0f} mm before"
        notes.append(f"wrong size: {end.format(1e3 * abs(beyond))} the mesh")
    solid = fit.superquadric
    if solid is not None and any(solid.taper):
        notes.append("size of the middle; taper " + " ".join(f"{k:.2f}" for k in solid.taper))
    return "; ".join(notes)


@dataclass(frozen=True)
class FitChoice:
    """The fit choices of the command line; None selects the default.

    Raises
    ------
    InputError
        If a value is out of range. The message names the option and the range.
    """

    kind: KindChoice = "auto"
    """Solid to fit."""
    noise_mm: float = 1.5
    """Expected noise of the points, one standard deviation, mm."""
    budget_ms: float | None = None
    """Time limit of a fit, ms."""
    max_parts: int | None = None
    """Maximum number of solids per object."""
    points: int | None = None
    """Number of points used."""
    optimiser: OptimiserName | None = None
    """Optimiser of the final refinement."""

    def __post_init__(self) -> None:
        if not 0.0 < self.noise_mm <= MAX_NOISE_MM:
            raise InputError(
                f"--noise-mm must be above 0 and at most {MAX_NOISE_MM:g}, got {self.noise_mm}"
            )
        if self.max_parts is not None and not 1 <= self.max_parts <= MAX_PARTS:
            raise InputError(f"--max-parts must be 1 to {MAX_PARTS}, got {self.max_parts}")
        if self.budget_ms is not None and not 0.0 < self.budget_ms < float("inf"):
            raise InputError(f"--budget-ms must be finite and above 0, got {self.budget_ms}")
        for name in ("points", "optimiser"):
            if self.budget_ms is not None and getattr(self, name) is not None:
                raise InputError(
                    f"--budget-ms and --{name} exclude each other: --budget-ms selects the {name}"
                )

    def options(self) -> FitOptions:
        """Return the options of the fit.

        Raises
        ------
        InputError
            If no setting of the stored front meets the budget, or a value is out of range.
        """
        chosen = FitOptions() if self.budget_ms is None else FitOptions.for_budget(self.budget_ms)
        changes: dict[str, Any] = {"noise": self.noise_mm * 1e-3}
        if self.kind != "auto":
            changes["kinds"] = (self.kind,)
        for name in ("points", "optimiser", "max_parts"):
            if getattr(self, name) is not None:
                changes[name] = getattr(self, name)
        return replace(chosen, **changes)
