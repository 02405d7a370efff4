"""The output files of a fit: JSON, picture, mesh, and a body for simulators."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

from scipy.spatial.transform import RigidTransform

from eyehand.perception.io import atomic_write
from eyehand.perception.superquadric import mesh

from ..drawn_solids import drawn_solids, solid_mesh
from ..mesh_file import MeshFormat, join_meshes, mesh_bytes
from ..scene_json import UNITS, fit_json, fit_parts
from .robot_files import MESH_RESOLUTION, needs_mesh, robot_files
from .solid_picture import fit_picture
from .solid_text import size_text

if TYPE_CHECKING:
    from pathlib import Path

    from eyehand.perception import Superquadric

    from .fit_inputs import FittedCloud

SCHEMA = "eyehand.solid/1"
"""Schema of the JSON file. A change that breaks readers increases the number."""


def solid_files(fitted: FittedCloud, *, form: MeshFormat, density: float) -> dict[str, bytes]:
    """Return the contents of all files of one fit, by name.

    Every fit has ``<stem>_solid.json`` and ``<stem>_solid.png``. A usable fit also has the mesh
    ``<stem>_solid.<form>`` in the frame of the cloud, and the bodies ``<stem>_body.xml`` (MJCF) and
    ``<stem>_body.urdf`` with their meshes ``<stem>_body*.stl``. The mesh of a vessel has its
    cavity. The bodies are its outer solid.

    Raises
    ------
    DeviceError
        If MuJoCo cannot be loaded or rejects the body.
    """
    stem, fit = fitted.cloud.stem, fitted.fit
    report = {"schema": SCHEMA, "units": UNITS, **_source(fitted), **fit_json(fit)}
    files = {
        f"{stem}_solid.json": (json.dumps(report, indent=1, allow_nan=False) + "\n").encode(),
        f"{stem}_solid.png": fit_picture(fitted),
    }
    if fit:
        parts = fit_parts(fit)
        surface = join_meshes([solid_mesh(one, MESH_RESOLUTION) for one in drawn_solids(fit)])
        files[f"{stem}_solid.{form}"] = mesh_bytes(*surface, form)
        files |= _body_files(stem, parts, density)
    return files


def write_files(folder: Path, files: dict[str, bytes]) -> None:
    """Write files to an existing folder, each of them atomically."""
    for name, content in files.items():
        with atomic_write(folder / name) as temporary:
            temporary.write_bytes(content)


def _source(fitted: FittedCloud) -> dict[str, object]:
    cloud, beyond = fitted.cloud, fitted.beyond_mesh
    origin, plane = (
        None if values is None else [round(float(x), 6) for x in values]
        for values in (cloud.view_origin, cloud.support_plane)
    )
    return {
        "source": cloud.name,
        "points": len(cloud.points),
        "view_origin_m": origin,
        "support_plane": plane and {"normal": plane[:3], "offset_m": plane[3]},
        "beyond_mesh_m": None if beyond is None else round(beyond, 5),
    }


def _body_files(stem: str, parts: tuple[Superquadric, ...], density: float) -> dict[str, bytes]:
    names: dict[int, str] = {}
    meshes: dict[str, bytes] = {}
    for number, part in enumerate(parts):
        if needs_mesh(part):
            names[number] = f"{stem}_body.stl" if len(parts) == 1 else f"{stem}_body_{number}.stl"
            centred = replace(part, pose=RigidTransform.identity())
            meshes[names[number]] = mesh_bytes(*mesh(centred, MESH_RESOLUTION), "stl")
    shapes = " and ".join(f"{part.kind} {size_text(part)}" for part in parts)
    note = f"eyehand fit: {shapes}; metres, in the frame of the cloud"
    bodies = robot_files(stem, parts, names, meshes, density=density, note=note)
    return {
        f"{stem}_body.xml": bodies.mjcf.encode(),
        f"{stem}_body.urdf": bodies.urdf.encode(),
        **meshes,
    }
