"""The files that one fitted cloud becomes: JSON, picture, mesh, and a body for robots."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception.io import atomic_write
from eyehand.perception.superquadric import mesh

from ..mesh_file import MeshFormat, mesh_bytes
from ..scene_json import UNITS, fit_json, fit_parts
from .robot_files import MESH_RESOLUTION, needs_mesh, robot_files
from .solid_picture import fit_picture
from .solid_text import size_text

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .fit_inputs import FittedCloud

SCHEMA = "eyehand.solid/1"
"""Of the JSON file; a change that breaks a reader raises the number."""


def solid_files(fitted: FittedCloud, *, form: MeshFormat, density: float) -> dict[str, bytes]:
    """Return the contents of all files of one fit, by name.

    ``<stem>_solid.json`` and ``<stem>_solid.png`` always; for a fit that can be used the mesh
    ``<stem>_solid.<form>`` in the cloud's frame, ``<stem>_body.xml`` (MJCF) and
    ``<stem>_body.urdf``, and the meshes ``<stem>_body*.stl`` that those two name.

    Raises
    ------
    DeviceError
        If MuJoCo cannot be loaded or refuses the body.
    """
    stem, fit = fitted.cloud.stem, fitted.fit
    report = {"schema": SCHEMA, "units": UNITS, **_source(fitted), **fit_json(fit)}
    files = {
        f"{stem}_solid.json": (json.dumps(report, indent=1, allow_nan=False) + "\n").encode(),
        f"{stem}_solid.png": fit_picture(fitted),
    }
    if fit:
        parts = fit_parts(fit)
        surface = _joined([mesh(part, MESH_RESOLUTION) for part in parts])
        files[f"{stem}_solid.{form}"] = mesh_bytes(*surface, form)
        files |= _body_files(stem, parts, density)
    return files


def write_files(folder: Path, files: dict[str, bytes]) -> None:
    """Write files to a folder that exists, each at once or not at all."""
    for name, content in files.items():
        with atomic_write(folder / name) as temporary:
            temporary.write_bytes(content)


def _source(fitted: FittedCloud) -> dict[str, object]:
    cloud = fitted.cloud
    plane = cloud.support_plane
    return {
        "source": cloud.name,
        "points": len(cloud.points),
        "view_origin_m": None
        if cloud.view_origin is None
        else [round(float(x), 6) for x in cloud.view_origin],
        "support_plane": None
        if plane is None
        else {
            "normal": [round(float(x), 6) for x in plane[:3]],
            "offset_m": round(float(plane[3]), 6),
        },
    }


def _body_files(stem: str, parts: tuple[Superquadric, ...], density: float) -> dict[str, bytes]:
    names: dict[int, str] = {}
    meshes: dict[str, bytes] = {}
    for number, part in enumerate(parts):
        if needs_mesh(part):
            names[number] = f"{stem}_body.stl" if len(parts) == 1 else f"{stem}_body_{number}.stl"
            own = replace(part, pose=RigidTransform.identity())
            meshes[names[number]] = mesh_bytes(*mesh(own, MESH_RESOLUTION), "stl")
    shapes = " and ".join(f"{part.kind} {size_text(part)}" for part in parts)
    note = f"eyehand fit: {shapes}; metres, in the frame of the cloud"
    made = robot_files(stem, parts, names, meshes, density=density, note=note)
    return {
        f"{stem}_body.xml": made.mjcf.encode(),
        f"{stem}_body.urdf": made.urdf.encode(),
        **meshes,
    }


def _joined(
    surfaces: Sequence[tuple[NDArray[np.float64], NDArray[np.int64]]],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """One mesh of several."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in surfaces)])
    return (
        np.concatenate([vertices for vertices, _ in surfaces]),
        np.concatenate(
            [faces + start for (_, faces), start in zip(surfaces, starts, strict=False)]
        ),
    )
