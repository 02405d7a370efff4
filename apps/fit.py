"""`eyehand fit`: the simplest solid for point clouds and meshes."""

from __future__ import annotations

import json as json_format
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from rich.markup import escape
from rich.table import Table

from eyehand.errors import InputError
from eyehand.perception import FitOptions, SuperquadricFit, fit_superquadric
from eyehand.perception.cloud_io import read_cloud
from eyehand.perception.superquadric import Kind, mesh

from .console import print_json, say, show, tracked
from .description import ready_kernels
from .description_files import make_folder, write_text
from .mesh_file import write_mesh
from .scene_json import UNITS, fit_json

if TYPE_CHECKING:
    from collections.abc import Sequence

MESH_RESOLUTION = 64
MAX_NOISE_MM = 100.0

KindChoice = Literal["auto", "sphere", "cylinder", "ellipsoid", "box", "superquadric"]


def fit_command(
    *clouds: Path,
    kind: KindChoice = "auto",
    view_origin: tuple[float, float, float] | None = None,
    plane: tuple[float, float, float, float] | None = None,
    noise_mm: float = 1.5,
    out: Path | None = None,
    json: bool = False,
) -> int:
    """Fit a superquadric to each cloud, as simple as its points allow.

    Parameters
    ----------
    clouds
        Files: .ply, .pcd, .npz (points), .xyz, .txt, .csv, or surfaces .obj, .stl; in metres.
    kind
        Solid to fit; auto takes the simplest that explains the points.
    view_origin
        Place of the camera in the cloud's frame, m: tells what the view shows to be empty.
    plane
        Support plane a b c d with a x + b y + c z + d = 0, normal towards the object.
    noise_mm
        Expected noise of the points, one standard deviation, mm.
    out
        Output folder for <name>_solid.json and the solid's mesh <name>_solid.ply.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if not clouds:
        raise InputError("give at least one cloud: eyehand fit CLOUD [CLOUD ...]")
    if not 0.0 < noise_mm <= MAX_NOISE_MM:
        raise InputError(f"--noise-mm must be above 0 and at most {MAX_NOISE_MM:g}, got {noise_mm}")
    if out is not None:
        _check_names(clouds)
    kinds: tuple[Kind, ...] = FitOptions().kinds if kind == "auto" else (kind,)
    options = FitOptions(kinds=kinds, noise=noise_mm * 1e-3)
    ready_kernels()
    fits = {}
    for path in tracked(clouds, "fitting", len(clouds)):
        fits[path] = fit_superquadric(
            read_cloud(path), view_origin=view_origin, support_plane=_unit(plane), options=options
        )
    if out is not None:
        make_folder(out)
        for path, fit in fits.items():
            _write(out, path, fit)
        say(f"solids written to {out}")
    show(_table(fits), json_wanted=json)
    if json:
        print_json("fit", options.seed, [_row(path, fit) for path, fit in fits.items()])
    return 0 if all(fits.values()) else 1


def _unit(plane: Sequence[float] | None) -> np.ndarray | None:
    if plane is None:
        return None
    length = float(np.linalg.norm(plane[:3]))
    if not np.all(np.isfinite(plane)) or not length > 0:
        raise InputError(f"--plane needs 4 finite numbers and a normal that is not 0, got {plane}")
    return np.asarray(plane, dtype=np.float64) / length


def _check_names(clouds: Sequence[Path]) -> None:
    """Refuse clouds whose results would overwrite one another."""
    stems = [path.stem for path in clouds]
    twice = sorted({stem for stem in stems if stems.count(stem) > 1})
    if twice:
        raise InputError(f"clouds of the same name {', '.join(twice)} need a folder each for --out")


def _write(folder: Path, path: Path, fit: SuperquadricFit) -> None:
    report = {"schema": "eyehand.solid/1", "units": UNITS, "source": str(path), **fit_json(fit)}
    write_text(
        folder / f"{path.stem}_solid.json",
        json_format.dumps(report, indent=1, allow_nan=False) + "\n",
    )
    if fit.superquadric is not None:
        write_mesh(folder / f"{path.stem}_solid.ply", *mesh(fit.superquadric, MESH_RESOLUTION))


def _row(path: Path, fit: SuperquadricFit) -> dict[str, Any]:
    report = fit_json(fit)
    return {
        "name": str(path),
        "converged": fit.converged,
        "reason": fit.reason,
        "spread_mm": None if report["spread_m"] is None else round(fit.spread * 1e3, 3),
        "fit_ms": round(fit.seconds * 1e3, 2),
        "solid": report["solid"],
    }


def _table(fits: dict[Path, SuperquadricFit]) -> Table:
    table = Table(title=f"{len(fits)} clouds", title_justify="left")
    for column in ("cloud", "solid", "size mm", "ε1 ε2", "centre mm", "spread mm", "ms"):
        table.add_column(column)
    table.add_column("note", overflow="fold")
    for path, fit in fits.items():
        solid = fit.superquadric
        if solid is None:
            table.add_row(escape(path.name), "none", "-", "-", "-", "-", "-", fit.reason)
            continue
        table.add_row(
            escape(path.name),
            solid.kind,
            " x ".join(f"{2e3 * a:.1f}" for a in solid.semi_axes),
            f"{solid.exponents[0]:.2f} {solid.exponents[1]:.2f}",
            " ".join(f"{1e3 * x:.1f}" for x in solid.centre),
            f"{fit.spread * 1e3:.2f}",
            f"{fit.seconds * 1e3:.0f}",
            fit.reason,
        )
    return table
