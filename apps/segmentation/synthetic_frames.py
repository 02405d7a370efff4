"""Render labelled frames from seeds: families of tabletop scenes with several depth noises."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import get_args

import numpy as np

from eyehand.data_synth import (
    DepthNoise,
    Family,
    FurnishedFamily,
    FurnishedOptions,
    FurnishedScene,
    RenderedView,
    TabletopOptions,
    TabletopScene,
    make_furnished_scene,
    make_scene,
    render_scene,
)
from eyehand.data_synth.render import SENSORS, DepthSensor, axial_sigma, capture, sensor_of
from eyehand.data_synth.scenes import FolderObject, read_objects
from eyehand.errors import InputError

from .dataset import FrameSource, LabelledFrame, slivers

EMPTY, EMPTY_BIN = "empty", "empty-bin"
"""Names of the families of tables and of bins without objects."""
EMPTY_FAMILIES = (EMPTY, EMPTY_BIN)
FAMILIES: tuple[str, ...] = (*get_args(Family), *get_args(FurnishedFamily), *EMPTY_FAMILIES)
"""Families of scenes."""
NOISES = ("none", "realistic", "1mm", "2mm", "3mm")
"""Default depth noises."""


@dataclass(frozen=True)
class FurnishedContents:
    """The contents of synthetic scenes with furniture, besides the furniture."""

    meshes: Path | None = None
    """Folder of .urdf, .obj or .stl files, whose objects take the place of random solids."""
    mesh_share: float = 1.0
    """Probability that an object is one of the meshes; the others are solids."""
    arm: bool = False
    """Show a robot arm that reaches into the furniture."""


MAX_DRAWS = 5
"""Number of seeds tried for a frame of a family that is hard to draw."""
_REDRAW_STEP = 1_000_003
"""Added to a seed that gave no scene. It is larger than any range of seeds in use."""


def synthetic_sources(
    families: Sequence[str] | None = None,
    noises: Sequence[str] | None = None,
    *,
    frames: int = 10,
    seed: int = 0,
    contents: FurnishedContents | None = None,
) -> list[FrameSource]:
    """List the frames of every family with every noise. All noises share the same scenes.

    Parameters
    ----------
    families
        Names from `FAMILIES`; default: all.
    noises
        Names, see :func:`depth_noise`; default: `NOISES`.
    frames
        Number of scenes per family.
    seed
        Seed of the first scene. The next scenes have the next seeds.
    contents
        What stands in scenes with furniture; solids by default.

    Returns
    -------
    list of FrameSource
        Their groups are named ``family/noise``.

    Raises
    ------
    InputError
        If a name is unknown or a number out of range.
    """
    families, noises = families or FAMILIES, noises or NOISES
    for family in families:
        if family not in FAMILIES:
            raise InputError(f"family {family!r} is unknown, expected {', '.join(FAMILIES)}")
    if frames < 1 or seed < 0:
        raise InputError(f"--frames must be >= 1 and --seed >= 0, got {frames} and {seed}")
    strengths = {noise: depth_noise(noise) for noise in noises}
    # The noises are the inner loop, so that a scene is drawn once for all of them.
    return [
        FrameSource(
            f"{family} {noise} seed {number}",
            f"{family}/{noise}",
            partial(_frame, family, number, strength, contents or FurnishedContents()),
        )
        for family in families
        for number in range(seed, seed + frames)
        for noise, strength in strengths.items()
    ]


def depth_noise(name: str) -> DepthNoise | DepthSensor:
    """Return the depth noise or the sensor with a name.

    ``none``: no noise. ``realistic``: all errors of the first Kinect. ``realistic*2``: the same
    errors, twice as strong. ``1.5mm``: independent normal errors along the optical axis, with this
    standard deviation at 1 m, growing with distance as in Nguyen's model (`DepthNoise.axial`).
    ``kinect-v1``, ``stereo``, ``structured-light``, ``oak``: that kind of camera (`SENSORS`).

    Raises
    ------
    InputError
        If the name is none of these.
    """
    if name == "none":
        return DepthNoise.none()
    number = r"(\d+(?:\.\d*)?|\.\d+)"
    if name == "realistic":
        return DepthNoise.realistic()
    if name in SENSORS:
        return sensor_of(name)
    if found := re.fullmatch(rf"realistic\*{number}", name):
        return DepthNoise.realistic(float(found[1]))
    if found := re.fullmatch(rf"{number}mm", name):
        return DepthNoise(axial=float(found[1]) * 1e-3 / float(axial_sigma(np.array(1.0))))
    raise InputError(
        f"noise {name!r} is unknown, expected none, realistic, realistic*2 (twice as strong), "
        f"1.5mm (standard deviation at 1 m), {', '.join(SENSORS)}"
    )


def _frame(
    family: str, seed: int, noise: DepthNoise | DepthSensor, contents: FurnishedContents
) -> LabelledFrame:
    scene, view = _view(family, seed, contents)
    frame = capture(scene, view, noise, np.random.default_rng(seed))
    unscored = slivers(view.labels) if family in get_args(FurnishedFamily) else None
    return LabelledFrame(frame, view.labels, view.background, unscored)


@lru_cache(maxsize=2)
def _view(
    family: str, seed: int, contents: FurnishedContents
) -> tuple[TabletopScene | FurnishedScene, RenderedView]:
    scene = _scene(family, seed, contents)
    return scene, render_scene(scene, colour=True)


@lru_cache(maxsize=2)
def _meshes(folder: Path) -> tuple[FolderObject, ...]:
    return read_objects(folder)


def _scene(family: str, seed: int, contents: FurnishedContents) -> TabletopScene | FurnishedScene:
    if family == EMPTY:
        # The camera is placed for one object, then the object is removed.
        lone = make_scene(seed, TabletopOptions(count_range=(1, 1)))
        return replace(lone, objects=())
    if family == EMPTY_BIN:
        return make_furnished_scene(seed, FurnishedOptions(family="bin", count_range=(0, 0)))
    furnished: dict[str, FurnishedFamily] = {name: name for name in get_args(FurnishedFamily)}
    if family in furnished:
        options = FurnishedOptions(
            family=furnished[family],
            meshes=() if contents.meshes is None else _meshes(contents.meshes),
            mesh_share=contents.mesh_share,
            arm=contents.arm,
        )
        return make_furnished_scene(seed, options)
    names = {name: name for name in get_args(Family)}
    options = TabletopOptions(family=names[family])
    for redraw in range(MAX_DRAWS - 1):
        try:
            return make_scene(seed + redraw * _REDRAW_STEP, options)
        except InputError:
            continue
    return make_scene(seed + (MAX_DRAWS - 1) * _REDRAW_STEP, options)
