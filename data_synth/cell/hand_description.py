"""Description of a hand with joint motors: the joints of each finger, and how they close."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from eyehand.errors import InputError

THUMB = "thumb"
"""Name of the finger that opposes the others."""
DESCRIPTION_SUFFIX = ".hand.json"
"""Suffix of a hand's description beside its MJCF: ``robot.xml``, ``robot.hand.json``."""

EXAMPLE = (
    '{"fingers": {"middle": {"joints": {"MFJ2": [0.8, 1.5]}, "pads": ["mf_tip"]}, "thumb": {…}}}'
)
"""Example of a description, for error messages."""


@dataclass(frozen=True)
class FingerDescription:
    """One finger, whose joints close together from an open to a closed posture.

    Raises
    ------
    InputError
        If there is no joint or no pad, or a joint's angles are not finite, or none of them moves.
    """

    name: str
    """Name. A pincer grasp uses "middle"; "thumb" opposes the other fingers."""
    joints: dict[str, tuple[float, float]]
    """Joints from the base to the tip, each with its position in the open and the closed posture,
    rad (m for slides). The MJCF file couples joints without a motor to others."""
    pads: tuple[str, ...]
    """Geoms that touch objects, from the base to the tip."""

    def __post_init__(self) -> None:
        if not self.joints or not self.pads:
            raise InputError(f"finger {self.name} must have at least one joint and one pad")
        if not all(math.isfinite(position) for pair in self.joints.values() for position in pair):
            raise InputError(
                f"finger {self.name}: joint positions must be finite, got {self.joints}"
            )
        if all(low == high for low, high in self.joints.values()):
            raise InputError(f"finger {self.name}: no joint moves from the open to the closed hand")


@dataclass(frozen=True)
class HandDescription:
    """A hand with joint motors, described finger by finger.

    Raises
    ------
    InputError
        If there is no thumb or no other finger, or a name is used twice.
    """

    fingers: tuple[FingerDescription, ...]
    """Fingers, the thumb last."""
    palm: tuple[str, ...] = ()
    """Geoms of the palm's face."""
    still: dict[str, float] = field(default_factory=dict)
    """Joints that keep a position, rad (m for slides), such as a wrist or the spread of fingers."""

    def __post_init__(self) -> None:
        names = [finger.name for finger in self.fingers]
        if len(names) < 2 or names[-1] != THUMB or len(set(names)) < len(names):
            raise InputError(
                f"a hand needs one or more fingers and last a {THUMB!r}, with different names; "
                f"got {', '.join(names) or 'none'}"
            )
        for kind, taken in (
            ("joint", [j for f in self.fingers for j in f.joints] + list(self.still)),
            ("pad", [p for f in self.fingers for p in f.pads] + list(self.palm)),
        ):
            twice = sorted({name for name in taken if taken.count(name) > 1})
            if twice:
                raise InputError(
                    f"a {kind} can belong to one finger only; used twice: {', '.join(twice)}"
                )

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints in readings: ``<finger>_<number>``."""
        return tuple(f"{f.name}_{k + 1}" for f in self.fingers for k in range(len(f.joints)))

    @property
    def pad_names(self) -> tuple[str, ...]:
        """Names of the pads in readings, such as ``middle_1``, ``middle_distal``, ``palm_pad``."""
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
        None if there is no such file.

    Raises
    ------
    InputError
        If the file exists but does not contain a description.
    """
    beside = Path(path).with_suffix(DESCRIPTION_SUFFIX)
    return read_description(beside) if beside.is_file() else None


def read_description(path: Path) -> HandDescription:
    """Read a hand's description from JSON.

    ``fingers``, ``palm`` and ``still`` are those of `HandDescription`. ``prefix`` is the prefix of
    all joints and geoms of the hand in the robot's file.

    Raises
    ------
    InputError
        If the file cannot be read, or a value in it is missing or of the wrong type.
    """
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot read the hand's description: {error}") from None
    try:
        return _description(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _description(data: Any) -> HandDescription:
    fingers = data.get("fingers") if isinstance(data, dict) else None
    if not isinstance(fingers, dict):
        raise InputError(f"the object 'fingers' is missing; expected {EXAMPLE}")
    unknown = sorted(set(data) - {"fingers", "palm", "still", "prefix"})
    if unknown:
        raise InputError(
            f"unknown keys {', '.join(unknown)}; valid are fingers, palm, still, prefix"
        )
    prefix = data.get("prefix", "")
    if not isinstance(prefix, str):
        raise InputError(f"'prefix' must be a string, got {prefix!r}")
    order = sorted(fingers, key=lambda name: name == THUMB)
    still = data.get("still", {})
    if not isinstance(still, dict):
        raise InputError(f"'still' must map joints to positions, got {still!r}")
    return HandDescription(
        tuple(_finger(name, fingers[name], prefix) for name in order),
        _names("palm", data.get("palm", []), prefix),
        {prefix + name: _number(f"still {name}", value) for name, value in still.items()},
    )


def _finger(name: str, data: Any, prefix: str) -> FingerDescription:
    joints = data.get("joints") if isinstance(data, dict) else None
    if not isinstance(joints, dict):
        raise InputError(f"finger {name} has no object 'joints'; expected {EXAMPLE}")
    positions = {}
    for joint, pair in joints.items():
        if not isinstance(pair, list) or len(pair) != 2:
            raise InputError(f"joint {joint} must have two positions, [open, closed], got {pair!r}")
        positions[prefix + joint] = (_number(joint, pair[0]), _number(joint, pair[1]))
    return FingerDescription(
        name, positions, _names(f"pads of {name}", data.get("pads", []), prefix)
    )


def _names(what: str, data: Any, prefix: str) -> tuple[str, ...]:
    if not isinstance(data, list) or not all(isinstance(name, str) for name in data):
        raise InputError(f"{what} must be a list of geom names, got {data!r}")
    return tuple(prefix + name for name in data)


def _number(what: str, data: Any) -> float:
    if isinstance(data, bool) or not isinstance(data, (int, float)) or not math.isfinite(data):
        raise InputError(f"{what} must be a finite number in rad, got {data!r}")
    return float(data)
