"""The conditions of an evaluation of grasping, one per row of the table."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import get_args

from eyehand.data_synth.cell import DESCRIPTION_SUFFIX
from eyehand.data_synth.pad import SENSORS
from eyehand.errors import InputError, named_files

from .jobs import Condition, Family

FAMILIES: tuple[Family, ...] = get_args(Family)
HARD_FRICTION, HARD_SHAKE_S = 0.6, 2.0
"""Conditions of the hard row of the default table: waxed wood, and a fast robot."""
MAX_FRICTION, MAX_SHAKE_S, MAX_LOAD_STEP = 3.0, 60.0, 10.0
"""Maximum values. Beyond them, hands do not differ."""
EXACT = "exact"
"""Name of a touch without imperfections."""
SOURCE_SUFFIXES = (".py", ".xml", ".json")
SOURCE_FOLDERS = (
    "errors",
    "perception",
    "control",
    "tactile",
    "grasping",
    "data_synth",
    "apps/grasp",
)
"""Folders and suffixes of the source files that the figures depend on."""
DIGEST_LENGTH = 12
"""Number of letters of a digest."""


def default_conditions(*, camera: bool, known: bool) -> list[Condition]:
    """Return the default rows: each family, and packed scenes under hard conditions."""
    rows = [Condition(family, known=pose) for family in FAMILIES for pose in _poses(camera, known)]
    return [*rows, *([Condition("packed", HARD_FRICTION, HARD_SHAKE_S)] if camera else [])]


def requested_conditions(
    families: Sequence[Family],
    frictions: Sequence[float],
    shakes: Sequence[float],
    load_steps: Sequence[float],
    sensors: Sequence[str],
    dials: tuple[str, str],
    *,
    camera: bool,
    known: bool,
) -> list[Condition]:
    """Return all combinations of the requested values, each with camera and known poses.

    Raises
    ------
    InputError
        If a family or sensor model is unknown, or a value is out of range.
    """
    for family in families:
        if family not in FAMILIES:
            raise InputError(f"--family {family}: unknown, expected {', '.join(FAMILIES)}")
    for friction, shake in product(frictions, shakes):
        check_condition(friction, shake)
    for step in load_steps:
        if not 1 <= step <= MAX_LOAD_STEP:
            raise InputError(f"--load-step must lie in [1, {MAX_LOAD_STEP:g}], got {step}")
    for sensor in sensors:
        if sensor != EXACT and sensor not in SENSORS:
            names = ", ".join([EXACT, *SENSORS])
            raise InputError(f"--sensor {sensor}: unknown, expected {names}")
    wanted: list[Family] = [family for family in FAMILIES if family in families]
    return [
        Condition(
            family,
            friction,
            shake,
            pose,
            *dials,
            load_step=step,
            sensor="" if sensor == EXACT else sensor,
        )
        for family, friction, shake, step, sensor, pose in product(
            wanted,
            dict.fromkeys(frictions),
            dict.fromkeys(shakes),
            dict.fromkeys(load_steps),
            dict.fromkeys(sensors),
            _poses(camera, known),
        )
    ]


def check_condition(friction: float, shake: float) -> None:
    """Check the friction of the pads and the duration of the shake, s.

    Raises
    ------
    InputError
        If a value is out of range or NaN.
    """
    if not 0 < friction <= MAX_FRICTION:
        raise InputError(f"--friction must lie in (0, {MAX_FRICTION:g}], got {friction}")
    if not 0 <= shake <= MAX_SHAKE_S:
        raise InputError(f"--shake must lie in [0, {MAX_SHAKE_S:g}] s, got {shake}")


def source_digest() -> str:
    """Return a digest of the source files. Rows of different code are not mixed."""
    root = Path(__file__).resolve().parents[3]
    digest = hashlib.sha256()
    for path in sorted(path for folder in SOURCE_FOLDERS for path in (root / folder).rglob("*")):
        if path.suffix in SOURCE_SUFFIXES:
            digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:DIGEST_LENGTH]


def folder_digest(path: Path) -> str:
    """Return a digest of a file, or of all files in a folder."""
    files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:DIGEST_LENGTH]


def robot_digest(path: Path) -> str:
    """Return a digest of the files of a robot. It changes with any hand, finger or mesh.

    Parameters
    ----------
    path
        MJCF file. The existing files that it includes or names are read as well, and
        ``robot.hand.json`` beside ``robot.xml``.
    """
    files = [path, path.with_suffix(DESCRIPTION_SUFFIX), *named_files(path)]
    digest = hashlib.sha256()
    for file in dict.fromkeys(files):
        if file.is_file():
            content = file.read_bytes()
            digest.update(f"{file.name} {len(content)} ".encode() + content)
    return digest.hexdigest()[:DIGEST_LENGTH]


def _poses(camera: bool, known: bool) -> tuple[bool, ...]:
    return ((False,) if camera else ()) + ((True,) if known else ())
