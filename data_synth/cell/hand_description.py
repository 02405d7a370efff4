"""Which joints of a foreign hand make up which finger, and from where to where they close."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from eyehand.errors import InputError

THUMB = "thumb"
"""Name of the finger that the others oppose."""
DESCRIPTION_SUFFIX = ".hand.json"
"""A hand's description lies beside its MJCF: ``robot.xml``, ``robot.hand.json``."""

EXAMPLE = (
    '{"fingers": {"middle": {"joints": {"MFJ2": [0.8, 1.5]}, "pads": ["mf_tip"]}, "thumb": {…}}}'
)
"""What a description looks like, for whoever has to write one."""


@dataclass(frozen=True)
class FingerDescription:
    """One finger: its joints close together, from an open posture to a closed one.

    Raises
    ------
    InputError
        If there is no joint or no pad, or a joint's angles are not finite, or none of them moves.
    """

    name: str
    """What it is called. "middle" is the one that a pincer uses, "thumb" the one that opposes."""
    joints: dict[str, tuple[float, float]]
    """Joints from the base to the tip, each with its place in the open and in the closed posture,
    rad (m where it slides). One without a motor is coupled to others by the file."""
    pads: tuple[str, ...]
    """Geoms that touch, from the base to the tip."""

    def __post_init__(self) -> None:
        if not self.joints or not self.pads:
            raise InputError(f"finger {self.name} must have one joint and one pad at least")
        if not all(math.isfinite(place) for pair in self.joints.values() for place in pair):
            raise InputError(f"finger {self.name}: places of joints must be finite: {self.joints}")
        if all(low == high for low, high in self.joints.values()):
            raise InputError(f"finger {self.name}: no joint moves from the open to the closed hand")


@dataclass(frozen=True)
class HandDescription:
    """A hand whose motors move joints, told finger by finger.

    Raises
    ------
    InputError
        If there is no thumb or nothing that it opposes, or a name is taken twice.
    """

    fingers: tuple[FingerDescription, ...]
    """Fingers, the thumb last."""
    palm: tuple[str, ...] = ()
    """Geoms of the palm's face."""
    still: dict[str, float] = field(default_factory=dict)
    """Joints that keep a place, rad (m where they slide): a wrist, a spreading of fingers."""

    def __post_init__(self) -> None:
        names = [finger.name for finger in self.fingers]
        if len(names) < 2 or names[-1] != THUMB or len(set(names)) < len(names):
            raise InputError(
                f"a hand needs one finger or more, and last a {THUMB!r}, with names of their own; "
                f"got {', '.join(names) or 'none'}"
            )
        for kind, taken in (
            ("joint", [j for f in self.fingers for j in f.joints] + list(self.still)),
            ("pad", [p for f in self.fingers for p in f.pads] + list(self.palm)),
        ):
            twice = sorted({name for name in taken if taken.count(name) > 1})
            if twice:
                raise InputError(
                    f"a {kind} can belong to one finger only; {', '.join(twice)} twice"
                )

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names by which the hand's readings tell joints: ``<finger>_<number>``."""
        return tuple(f"{f.name}_{k + 1}" for f in self.fingers for k in range(len(f.joints)))

    @property
    def pad_names(self) -> tuple[str, ...]:
        """Names by which readings tell pads: numbers, the tip's ``distal``; last the palm's."""
        names = [
            f"{f.name}_{'distal' if k == len(f.pads) - 1 else k + 1}"
            for f in self.fingers
            for k in range(len(f.pads))
        ]
        return (*names, "palm_pad")


def description_beside(path: Path) -> HandDescription | None:
    """Read the description beside an MJCF file, ``robot.hand.json`` of ``robot.xml``.

    Returns
    -------
    HandDescription or None
        None when there is no such file.

    Raises
    ------
    InputError
        If the file is there and does not hold a description.
    """
    beside = Path(path).with_suffix(DESCRIPTION_SUFFIX)
    return read_description(beside) if beside.is_file() else None


def read_description(path: Path) -> HandDescription:
    """Read a hand's description from JSON.

    ``fingers``, ``palm`` and ``still`` are those of `HandDescription`; ``prefix`` is what stands
    before all names of joints and geoms in the robot's file, as attaching a hand puts it there.

    Raises
    ------
    InputError
        If the file cannot be read, or something in it is missing or of another kind.
    """
    try:
        told = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot read the hand's description: {error}") from None
    try:
        return _description(told)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _description(told: Any) -> HandDescription:
    fingers = told.get("fingers") if isinstance(told, dict) else None
    if not isinstance(fingers, dict):
        raise InputError(f"there is no object 'fingers'; expected {EXAMPLE}")
    unknown = sorted(set(told) - {"fingers", "palm", "still", "prefix"})
    if unknown:
        raise InputError(f"unknown {', '.join(unknown)}; known are fingers, palm, still, prefix")
    prefix = told.get("prefix", "")
    if not isinstance(prefix, str):
        raise InputError(f"'prefix' must be what the names begin with, got {prefix!r}")
    order = sorted(fingers, key=lambda name: name == THUMB)
    still = told.get("still", {})
    if not isinstance(still, dict):
        raise InputError(f"'still' must map joints to places, got {still!r}")
    return HandDescription(
        tuple(_finger(name, fingers[name], prefix) for name in order),
        _names("palm", told.get("palm", []), prefix),
        {prefix + name: _number(f"still {name}", value) for name, value in still.items()},
    )


def _finger(name: str, told: Any, prefix: str) -> FingerDescription:
    joints = told.get("joints") if isinstance(told, dict) else None
    if not isinstance(joints, dict):
        raise InputError(f"finger {name} has no object 'joints'; expected {EXAMPLE}")
    places = {}
    for joint, pair in joints.items():
        if not isinstance(pair, list) or len(pair) != 2:
            raise InputError(f"joint {joint} must have two places, [open, closed], got {pair!r}")
        places[prefix + joint] = (_number(joint, pair[0]), _number(joint, pair[1]))
    return FingerDescription(name, places, _names(f"pads of {name}", told.get("pads", []), prefix))


def _names(what: str, told: Any, prefix: str) -> tuple[str, ...]:
    if not isinstance(told, list) or not all(isinstance(name, str) for name in told):
        raise InputError(f"{what} must be a list of names of geoms, got {told!r}")
    return tuple(prefix + name for name in told)


def _number(what: str, told: Any) -> float:
    if isinstance(told, bool) or not isinstance(told, (int, float)) or not math.isfinite(told):
        raise InputError(f"{what} must be a finite number in rad, got {told!r}")
    return float(told)
