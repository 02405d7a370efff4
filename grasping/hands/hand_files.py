"""Load the description of a hand by its name or from a JSON file.

The file holds one object. Lengths are in m, forces in N, boxes in the tool frame of
:class:`.ParallelHand`::

    {
      "schema": "eyehand.hand/1",       required
      "kind": "parallel",               required
      "name": "panda",                  required
      "stroke": 0.08,                   required: maximum opening
      "finger_boxes": [{"low": [x, y, z], "high": [x, y, z]}, …],   required: the jaw at +x
      "finger_depth": 0.044,            required
      "pad_width": 0.017, "pad_height": 0.018,                      required
      "palm_boxes": [box, …],           required
      "min_opening": 0.0, "force": [10, 70], "camera_boxes": [box, …],
      "mount_distance": 0.112, "tip_advance": 0.0,
      "senses": ["width", "effort", "pad_forces", "tactile"],
      "joints": [{"name": text, "open": position, "closed": position}, …],    m or rad
      "source": "text", "checked": true, "notes": "text"
    }
"""

from __future__ import annotations

import json
from dataclasses import MISSING, asdict, fields
from functools import cache
from pathlib import Path
from typing import Any

from eyehand.errors import InputError

from .parallel_hand import HandBox, HandJoint, ParallelHand, generic_jaw

SCHEMA = "eyehand.hand/1"
"""Value of ``schema`` in a hand's file."""
FOLDER = Path(__file__).parent / "descriptions"
"""Folder of the built-in hands."""
GENERIC = "generic"
"""Name of the hand of :func:`.generic_jaw` with its default sizes."""

_BOXES = ("finger_boxes", "palm_boxes", "camera_boxes")
_TEXTS = ("name", "source", "notes")


def built_in_hands() -> tuple[str, ...]:
    """Return the names of the built-in hands in alphabetical order."""
    return tuple(sorted([*(path.stem for path in FOLDER.glob("*.json")), GENERIC]))


def load_hand(name_or_path: str | Path) -> ParallelHand:
    """Load a built-in hand by its name, or a hand from a JSON file.

    Raises
    ------
    InputError
        If there is no such hand or file, or a value in the file is missing or invalid.
    """
    text = str(name_or_path)
    if text == GENERIC:
        return generic_jaw()
    if text in built_in_hands():
        return _built_in(text)
    path = Path(name_or_path)
    if path.suffix.lower() != ".json" and not path.is_file():
        raise InputError(
            f"there is no hand {text!r}; valid names are {', '.join(built_in_hands())}, "
            "or the path of a .json file"
        )
    return read_hand(path)


def read_hand(path: Path | str) -> ParallelHand:
    """Read a hand from a JSON file; see the module for its fields.

    Raises
    ------
    InputError
        If the file cannot be read, or a value is missing or invalid.
    """
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot read a hand: {error}") from None
    try:
        return _hand(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_hand(hand: ParallelHand, path: Path | str) -> None:
    """Write a hand to a JSON file that `read_hand` reads."""
    data = {"schema": SCHEMA, "kind": "parallel", **asdict(hand)}
    Path(path).write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")


@cache
def _built_in(name: str) -> ParallelHand:
    return read_hand(FOLDER / f"{name}.json")


def _hand(data: Any) -> ParallelHand:
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise InputError(f"'schema' must be {SCHEMA!r}")
    if data.get("kind") != "parallel":
        raise InputError(f"'kind' must be 'parallel', got {data.get('kind')!r}")
    known = {item.name: item for item in fields(ParallelHand)}
    given = {key: value for key, value in data.items() if key not in ("schema", "kind")}
    unknown = sorted(set(given) - set(known))
    if unknown:
        raise InputError(f"unknown keys {', '.join(unknown)}; valid are {', '.join(known)}")
    missing = [key for key, item in known.items() if item.default is MISSING and key not in given]
    if missing:
        raise InputError(f"missing keys: {', '.join(missing)}")
    return ParallelHand(**{key: _value(key, value) for key, value in given.items()})


def _value(key: str, value: Any) -> Any:
    """Convert a value of the file to that of the field."""
    if key in _BOXES:
        if not isinstance(value, list):
            raise InputError(f"{key!r} must be a list of boxes, got {value!r}")
        return tuple(_box(key, item) for item in value)
    if key == "joints":
        if not isinstance(value, list):
            raise InputError(f"'joints' must be a list, got {value!r}")
        return tuple(_joint(item) for item in value)
    if key in _TEXTS:
        if not isinstance(value, str):
            raise InputError(f"{key!r} must be text, got {value!r}")
        return value
    if key == "checked":
        if not isinstance(value, bool):
            raise InputError(f"'checked' must be true or false, got {value!r}")
        return value
    if key == "senses":
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise InputError(f"'senses' must be a list of names, got {value!r}")
        return tuple(value)
    if key == "force":
        low, high = _numbers(key, value, 2)
        return low, high
    return _numbers(key, [value], 1)[0]


def _box(key: str, data: Any) -> HandBox:
    if not isinstance(data, dict) or set(data) != {"low", "high"}:
        raise InputError(f"a box of {key!r} must have 'low' and 'high', got {data!r}")
    low, high = (_numbers(f"{name} of {key}", data[name], 3) for name in ("low", "high"))
    return HandBox((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def _joint(data: Any) -> HandJoint:
    if (
        not isinstance(data, dict)
        or set(data) != {"name", "open", "closed"}
        or not isinstance(data["name"], str)
    ):
        raise InputError(f"a joint must have 'name', 'open' and 'closed', got {data!r}")
    at_open, at_closed = (_numbers(key, [data[key]], 1)[0] for key in ("open", "closed"))
    return HandJoint(data["name"], at_open, at_closed)


def _numbers(key: str, value: Any, count: int) -> list[float]:
    if (
        not isinstance(value, list)
        or len(value) != count
        or not all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in value)
    ):
        shown = value[0] if count == 1 and isinstance(value, list) else value
        expected = "a number" if count == 1 else f"{count} numbers"
        raise InputError(f"{key!r} must be {expected}, got {shown!r}")
    return [float(x) for x in value]
