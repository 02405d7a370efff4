"""`eyehand synth`: render a synthetic frame with its ground truth."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
from rich.table import Table

from eyehand.data_synth import (
    DepthNoise,
    Family,
    FurnishedFamily,
    FurnishedOptions,
    FurnishedScene,
    TabletopObject,
    TabletopOptions,
    TabletopScene,
    make_furnished_scene,
    make_scene,
    render_scene,
    write_scene,
)
from eyehand.data_synth.render import SensorName, capture, sensor_of
from eyehand.data_synth.scenes import (
    COUNT_RANGES,
    MAX_FURNISHED_OBJECTS,
    MAX_OBJECTS,
    MIN_OBJECTS,
    MeshObject,
    read_objects,
)
from eyehand.errors import InputError

from .console import print_json, say, show
from .run_folder import claim_folder

OBJECTS = 5
"""Default number of objects on a plain table."""


def synth(
    *,
    seed: int = 0,
    out: Path = Path("out/synth"),
    objects: int | None = None,
    family: Literal[Family, FurnishedFamily] = "separate",
    meshes: Path | None = None,
    mesh_share: float = 1.0,
    arm: bool = False,
    noise: Literal["realistic", "none"] = "realistic",
    noise_scale: float = 1.0,
    sensor: SensorName | None = None,
    json: bool = False,
) -> int:
    """Render one random scene to a depth frame with its ground truth.

    Physics lets the objects settle before the scene is rendered.

    Writes depth.png (16 bit, mm) with depth.json and depth_colour.png, true_labels.png,
    true_background.png (kinds of background) and ground_truth.json.

    Parameters
    ----------
    seed
        Seed of the scene and of the noise.
    out
        Output folder.
    objects
        Number of objects, or 0 for an empty table or furniture. Default: 5 on a plain table, a
        random number on furniture.
    family
        On a plain table: separate, touching, stacked, dropped apart, or piled. In and on
        furniture: bin, tote, shelf, tray (with objects beside it), clutter (on a table in a room),
        small-table.
    meshes
        Folder of .urdf, .obj or .stl files, whose objects take the place of random solids on
        furniture.
    mesh_share
        Probability that an object is one of the meshes; the others are solids.
    arm
        Show a robot arm that reaches into the furniture.
    noise
        Depth noise of a structured-light camera, or none.
    noise_scale
        Multiplies every term of the noise.
    sensor
        Kind of camera whose errors take the place of the noise: the first Kinect, active stereo,
        fine structured light, or passive stereo (OAK).
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    if not noise_scale >= 0:
        raise InputError(f"--noise-scale must be >= 0, got {noise_scale}")
    began = time.perf_counter()
    if family in COUNT_RANGES:
        options = _furnished_options(family, objects, meshes, mesh_share)
        scene = make_furnished_scene(seed, replace(options, arm=arm))
    else:
        if meshes is not None or arm:
            raise InputError(
                f"{'--arm' if arm else '--meshes'} needs a family of {', '.join(COUNT_RANGES)}, "
                f"got --family {family}"
            )
        scene = _tabletop(seed, cast("Family", family), OBJECTS if objects is None else objects)
    claim_folder(out)
    settled = time.perf_counter()
    chosen = DepthNoise.none() if noise == "none" else DepthNoise.realistic(noise_scale)
    view = render_scene(scene)
    frame = capture(
        scene, view, chosen if sensor is None else sensor_of(sensor), np.random.default_rng(seed)
    )
    rendered = time.perf_counter()
    files = write_scene(out, scene, frame, view.labels, view.background)
    show(_table(scene), json_wanted=json)
    say(f"{', '.join(file.name for file in files)} in {out}")
    if json:
        rows = [
            {
                "name": item.name,
                "kind": _kind(item),
                "size_mm": [round(1e3 * extent, 2) for extent in _extents(item)],
                "mass_g": round(item.mass * 1e3, 1),
                "pixels": int((view.labels == number).sum()),
            }
            for number, item in enumerate(scene.objects, start=1)
        ]
        times: dict[str, Any] = {
            "settle_ms": round((settled - began) * 1e3, 1),
            "render_ms": round((rendered - settled) * 1e3, 1),
        }
        print_json("synth", seed, rows, out=str(out), **times)
    return 0


def _tabletop(seed: int, family: Family, objects: int) -> TabletopScene:
    fewest = MIN_OBJECTS[family]
    if not fewest <= objects <= MAX_OBJECTS:
        raise InputError(
            f"--objects must be {fewest} to {MAX_OBJECTS} for the family {family}, got {objects}"
        )
    return make_scene(seed, TabletopOptions(family=family, count_range=(objects, objects)))


def _furnished_options(
    family: FurnishedFamily, objects: int | None, meshes: Path | None, mesh_share: float
) -> FurnishedOptions:
    if objects is not None and not 0 <= objects <= MAX_FURNISHED_OBJECTS:
        raise InputError(
            f"--objects must be 0 to {MAX_FURNISHED_OBJECTS} for the family {family}, got {objects}"
        )
    return FurnishedOptions(
        family=family,
        count_range=None if objects is None else (objects, objects),
        meshes=() if meshes is None else read_objects(meshes),
        mesh_share=mesh_share,
    )


def _kind(item: TabletopObject | MeshObject) -> str:
    return "mesh" if isinstance(item, MeshObject) else item.kind


def _extents(item: TabletopObject | MeshObject) -> list[float]:
    """Return the object's extents along its own axes, m."""
    if isinstance(item, MeshObject):
        return np.ptp(item.vertices, axis=0).tolist()
    return (2 * item.shape.semi_axes).tolist()


def _table(scene: TabletopScene | FurnishedScene) -> Table:
    table = Table(title=f"seed {scene.seed}, {scene.family}", title_justify="left")
    for column in ("#", "object", "size mm", "mass g", "at mm"):
        table.add_column(column)
    for number, item in enumerate(scene.objects, start=1):
        centre = item.centre if isinstance(item, MeshObject) else item.shape.centre
        table.add_row(
            str(number),
            _kind(item) if not isinstance(item, MeshObject) else item.name,
            " x ".join(f"{1e3 * extent:.0f}" for extent in _extents(item)),
            f"{item.mass * 1e3:.0f}",
            " ".join(f"{1e3 * x:.0f}" for x in centre),
        )
    return table
