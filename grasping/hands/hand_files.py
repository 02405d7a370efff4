"""Load the description of a hand by its name or from a JSON file.

docs/guides/hand_description.md describes the fields of the file. Its JSON schema is
descriptions/schema.json.
"""

from __future__ import annotations

import json
from dataclasses import MISSING, asdict, fields
from functools import cache
from pathlib import Path
from typing import Any

from eyehand.errors import InputError
from eyehand.perception.io import atomic_write

from .generic_jaw import generic_jaw
from .parallel_hand import KINDS, HandBox, HandJoint, ParallelHand, ToolPose

SCHEMA = "eyehand.hand/1"
"""Value of ``schema`` in a hand's file."""
FOLDER = Path(__file__).parent / "descriptions"
"""Folder of the built-in hands."""
GENERIC = "generic"
"""Name of the hand of :func:`.generic_jaw` with its default sizes."""

MAX_BETWEEN = 1000
"""Maximum number of positions of a joint."""
MAX_BYTES = 1_000_000
"""Maximum size of a hand's file."""

_BOXES = ("finger_boxes", "palm_boxes", "camera_boxes")
_TEXTS = ("name", "kind", "pre_shape", "source", "notes")


def built_in_hands() -> tuple[str, ...]:
    """Return the names of the built-in hands in alphabetical order."""
    return tuple(
        sorted([*(path.stem for path in FOLDER.glob("*.json") if path.stem != "schema"), GENERIC])
    )


def load_hand(name_or_path: str | Path) -> ParallelHand:
    """Load a built-in hand by its name, or a hand from a JSON file.

    Raises
    ------
    InputError
        If the hand or the file does not exist, or a value in the file is missing or invalid.
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
    data = _read_json(Path(path))
    try:
        return _hand(data)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_hand(hand: ParallelHand, path: Path | str) -> None:
    """Write a hand to a JSON file that `read_hand` reads."""
    with atomic_write(Path(path)) as temporary:
        temporary.write_text(hand_json(hand) + "\n", encoding="utf-8")


def hand_json(hand: ParallelHand) -> str:
    """Return the text of a hand's JSON file."""
    values = asdict(hand)
    kind = values.pop("kind")
    given = {name: value for name, value in values.items() if value != () and value is not None}
    for joint in given.get("joints", ()):
        if not joint["between"]:
            del joint["between"]
    lines = []
    for name, value in {"schema": SCHEMA, "kind": kind, **given}.items():
        if isinstance(value, tuple) and isinstance(value[0], dict):
            rows = ",\n".join(f"    {json.dumps(row)}" for row in value)
            lines.append(f'  "{name}": [\n{rows}\n  ]')
        else:
            lines.append(f'  "{name}": {json.dumps(value)}')
    return "{\n" + ",\n".join(lines) + "\n}"


def _read_json(path: Path) -> Any:
    try:
        if path.exists() and not path.is_file():
            raise InputError(
                f"{path} must be a hand's .json file, but it is a folder, FIFO or device"
            )
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise InputError(
                f"{path} has {size / 1e6:.0f} MB; the file of a hand has at most "
                f"{MAX_BYTES / 1e6:.0f} MB"
            )
        return json.loads(path.read_text(encoding="utf-8"))
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot read a hand: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        hint = ""
        if path.suffix.lower() in (".xml", ".urdf"):
            hint = f"; describe it first: eyehand hand describe {path} --output hand.json"
        raise InputError(f"{path}: this is no hand's .json file: {error}{hint}") from None


@cache
def _built_in(name: str) -> ParallelHand:
    return read_hand(FOLDER / f"{name}.json")


def _hand(data: Any) -> ParallelHand:
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise InputError(f"'schema' must be {SCHEMA!r}")
    if data.get("kind") not in KINDS:
        raise InputError(
            f"'kind' must be {' or '.join(map(repr, KINDS))}, got {data.get('kind')!r}"
        )
    known = {item.name: item for item in fields(ParallelHand)}
    given = {key: value for key, value in data.items() if key != "schema"}
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
    if key == "tool":
        return _tool(value)
    if key in ("force", "middle_shift"):
        low, high = _numbers(key, value, 2)
        return low, high
    return _numbers(key, [value], 1)[0]


def _box(key: str, data: Any) -> HandBox:
    if not isinstance(data, dict) or set(data) != {"low", "high"}:
        raise InputError(f"a box of {key!r} must have 'low' and 'high', got {data!r}")
    low, high = (_numbers(f"{name} of {key}", data[name], 3) for name in ("low", "high"))
    return HandBox((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def _tool(data: Any) -> ToolPose:
    if (
        not isinstance(data, dict)
        or set(data) != {"body", "position", "quat_wxyz"}
        or not isinstance(data["body"], str)
    ):
        raise InputError(f"'tool' must have 'body', 'position' and 'quat_wxyz', got {data!r}")
    x, y, z = _numbers("position", data["position"], 3)
    qw, qx, qy, qz = _numbers("quat_wxyz", data["quat_wxyz"], 4)
    return ToolPose(data["body"], (x, y, z), (qw, qx, qy, qz))


def _joint(data: Any) -> HandJoint:
    if (
        not isinstance(data, dict)
        or set(data) | {"between"} != {"name", "open", "closed", "between"}
        or not isinstance(data["name"], str)
    ):
        raise InputError(
            f"a joint must have 'name', 'open' and 'closed', and may have 'between', got {data!r}"
        )
    at_open, at_closed = (_numbers(key, [data[key]], 1)[0] for key in ("open", "closed"))
    between = data.get("between", [])
    if not isinstance(between, list) or len(between) > MAX_BETWEEN:
        raise InputError(
            f"'between' of joint {data['name']!r} must be a list of at most {MAX_BETWEEN} numbers"
        )
    positions = tuple(_numbers("between", between, len(between)))
    return HandJoint(data["name"], at_open, at_closed, positions)


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
