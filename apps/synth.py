"""`eyehand synth`: render a synthetic tabletop frame with its ground truth."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from rich.table import Table

from eyehand.data_synth import (
    DepthNoise,
    Family,
    TabletopOptions,
    make_scene,
    render_frame,
    write_scene,
)
from eyehand.data_synth.scenes import MAX_OBJECTS, MIN_OBJECTS
from eyehand.errors import InputError

from .console import print_json, say, show

if TYPE_CHECKING:
    from eyehand.data_synth import TabletopScene


def synth(
    *,
    seed: int = 0,
    out: Path = Path("out/synth"),
    objects: int = 5,
    family: Family = "separate",
    noise: Literal["realistic", "none"] = "realistic",
    noise_scale: float = 1.0,
    json: bool = False,
) -> int:
    """Render one random tabletop scene to a depth frame with its ground truth.

    Physics lets the objects settle before the scene is rendered.

    Writes depth.png (16 bit, mm) with depth.json and depth_colour.png, true_labels.png and
    ground_truth.json.

    Parameters
    ----------
    seed
        Seed of the scene and of the noise.
    out
        Output folder.
    objects
        Number of objects, 1 to 15, or 0 for an empty table.
    family
        Arrangement of the objects: apart, side by side, stacked, dropped apart, or piled.
    noise
        Depth noise of a structured-light camera, or none.
    noise_scale
        Multiplies every term of the noise.
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    fewest = MIN_OBJECTS[family]
    if not fewest <= objects <= MAX_OBJECTS:
        raise InputError(
            f"--objects must be {fewest} to {MAX_OBJECTS} for the family {family}, got {objects}"
        )
    if not noise_scale >= 0:
        raise InputError(f"--noise-scale must be >= 0, got {noise_scale}")
    began = time.perf_counter()
    scene = make_scene(seed, TabletopOptions(family=family, count_range=(objects, objects)))
    settled = time.perf_counter()
    chosen = DepthNoise.none() if noise == "none" else DepthNoise.realistic(noise_scale)
    frame, labels = render_frame(scene, chosen, seed)
    rendered = time.perf_counter()
    files = write_scene(out, scene, frame, labels)
    show(_table(scene), json_wanted=json)
    say(f"{', '.join(file.name for file in files)} in {out}")
    if json:
        rows = [
            {
                "name": item.name,
                "kind": item.kind,
                "size_mm": [round(2e3 * a, 2) for a in item.shape.semi_axes.tolist()],
                "mass_g": round(item.mass * 1e3, 1),
                "pixels": int((labels == number).sum()),
            }
            for number, item in enumerate(scene.objects, start=1)
        ]
        times = {
            "settle_ms": round((settled - began) * 1e3, 1),
            "render_ms": round((rendered - settled) * 1e3, 1),
        }
        print_json("synth", seed, rows, out=str(out), **times)
    return 0


def _table(scene: TabletopScene) -> Table:
    table = Table(title=f"seed {scene.seed}, {scene.family}", title_justify="left")
    for column in ("#", "object", "size mm", "mass g", "at mm"):
        table.add_column(column)
    for number, item in enumerate(scene.objects, start=1):
        table.add_row(
            str(number),
            item.kind,
            " x ".join(f"{2e3 * a:.0f}" for a in item.shape.semi_axes),
            f"{item.mass * 1e3:.0f}",
            " ".join(f"{1e3 * x:.0f}" for x in item.shape.centre),
        )
    return table
