"""Which rows an evaluation of grasping has: the usual table's, or those asked for."""

from __future__ import annotations

import hashlib
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from eyehand.errors import InputError

from .jobs import Condition, Family

if TYPE_CHECKING:
    from collections.abc import Sequence

FAMILIES: tuple[Family, ...] = get_args(Family)
HARD_FRICTION, HARD_SHAKE_S = 0.6, 2.0
"""Of the hard row of the usual table: waxed wood, and a robot in a hurry."""
MOST_FRICTION, MOST_SHAKE_S = 3.0, 60.0
"""Beyond, no hand is told from another."""
SOURCES = (".py", ".xml", ".json")
ROOMS = ("errors", "perception", "control", "tactile", "grasping", "data_synth", "apps/grasp")
"""Files of the package that figures depend on."""


def usual_conditions(*, camera: bool, known: bool) -> list[Condition]:
    """Rows of the table everybody gets: each family, and packed scenes made hard."""
    rows = [Condition(family, known=pose) for family in FAMILIES for pose in _poses(camera, known)]
    return [*rows, *([Condition("packed", HARD_FRICTION, HARD_SHAKE_S)] if camera else [])]


def asked_conditions(
    families: Sequence[Family],
    frictions: Sequence[float],
    shakes: Sequence[float],
    dials: tuple[str, str],
    *,
    camera: bool,
    known: bool,
) -> list[Condition]:
    """All combinations of what was asked for, each once, the known pose beside the camera.

    Raises
    ------
    InputError
        If a family is unknown, or a figure out of its range.
    """
    for family in families:
        if family not in FAMILIES:
            raise InputError(f"--family {family}: there is none, expected {', '.join(FAMILIES)}")
    for friction, shake in product(frictions, shakes):
        check_condition(friction, shake)
    wanted: list[Family] = [family for family in FAMILIES if family in families]
    return [
        Condition(family, friction, shake, pose, *dials)
        for family, friction, shake, pose in product(
            wanted, dict.fromkeys(frictions), dict.fromkeys(shakes), _poses(camera, known)
        )
    ]


def check_condition(friction: float, shake: float) -> None:
    """Check the friction of the pads and the time of shaking, s.

    Raises
    ------
    InputError
        If one is out of its range, or not a number.
    """
    if not 0 < friction <= MOST_FRICTION:
        raise InputError(f"--friction must lie in (0, {MOST_FRICTION:g}], got {friction}")
    if not 0 <= shake <= MOST_SHAKE_S:
        raise InputError(f"--shake must lie in [0, {MOST_SHAKE_S:g}] s, got {shake}")


def source_digest() -> str:
    """Digest of the package's own files: rows of other code are other rows."""
    root = Path(__file__).resolve().parents[3]
    digest = hashlib.sha256()
    for path in sorted(path for room in ROOMS for path in (root / room).rglob("*")):
        if path.suffix in SOURCES:
            digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def folder_digest(path: Path) -> str:
    """Digest of a file, or of all files in a folder."""
    files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:12]


def _poses(camera: bool, known: bool) -> tuple[bool, ...]:
    return ((False,) if camera else ()) + ((True,) if known else ())
