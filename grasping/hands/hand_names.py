"""Names of a hand's parts with a meaning, and checks of them."""

from __future__ import annotations

from eyehand.errors import InputError

THUMB = "thumb"
"""Name of the finger that opposes all others, and of its drive."""
PINCER_FINGER = "middle"
"""Name of the finger that pinches against the thumb, and of its drive."""
WRAP_DRIVES = ("wrap", "thumb_wrap")
"""Names of the drives that bend the outer joints of fingers and thumb around an object."""
TIP = "distal"
"""End of the names of fingertip pads."""
PALM = "palm"
"""Begin of the names of palm pads."""


def check_names(
    drives: tuple[str, ...],
    joints: tuple[str, ...],
    pads: tuple[str, ...],
    fingers: tuple[str, ...],
) -> None:
    """Check the names of a hand's parts.

    Parameters
    ----------
    drives, joints, pads, fingers
        Names as in :class:`~.hand_model.HandModel`, which lists the rules.

    Raises
    ------
    InputError
        If a name breaks a rule.
    """
    for kind, names in (("drives", drives), ("joints", joints), ("pads", pads)):
        _check_unique(kind, names)
    _check_fingers(fingers)
    _check_drives(drives, fingers)
    _check_pads(pads, fingers)
    _check_begins("joint", joints, fingers)


def _check_unique(kind: str, names: tuple[str, ...]) -> None:
    twice = sorted({name for name in names if not name or names.count(name) > 1})
    if twice:
        raise InputError(
            f"{kind} of a hand must have unique, non-empty names, but {_quoted(twice)} is not; "
            f"got {_quoted(names)}"
        )


def _check_fingers(fingers: tuple[str, ...]) -> None:
    _check_unique("fingers", fingers)
    if len(fingers) < 2 or fingers[-1] != THUMB:
        raise InputError(
            f"fingers of a hand must be one or more fingers, then {THUMB!r}; got {_quoted(fingers)}"
        )
    for name in fingers:
        begins = [other for other in (*fingers, PALM) if other != name and name.startswith(other)]
        if begins or name in WRAP_DRIVES:
            raise InputError(
                f"finger {name!r} must have another name: it must not begin with "
                f"{_quoted(begins)}, because pads and joints begin with their finger's name"
                if begins
                else f"finger {name!r} must have another name: {_quoted(WRAP_DRIVES)} are drives"
            )


def _check_drives(drives: tuple[str, ...], fingers: tuple[str, ...]) -> None:
    valid = (
        f"valid are {_quoted(fingers)} (moves that finger), {_quoted(WRAP_DRIVES)} (bend outer "
        "joints), and any other name for a drive of all fingers without a drive of the same name"
    )
    if THUMB not in drives:
        raise InputError(f"one drive must be {THUMB!r}; got {_quoted(drives)}; {valid}")
    shared = [name for name in drives if name not in (*fingers, *WRAP_DRIVES)]
    alone = [name for name in fingers if name not in drives]
    if alone and not shared:
        raise InputError(f"no drive moves {_quoted(alone)}; got {_quoted(drives)}; {valid}")
    if shared and not alone:
        raise InputError(
            f"drive {_quoted(shared)} moves nothing, because every finger has a drive of the "
            f"same name; {valid}"
        )


def _check_pads(pads: tuple[str, ...], fingers: tuple[str, ...]) -> None:
    tips = tuple(f"{name}_{TIP}" for name in fingers)
    missing = [name for name in tips if name not in pads]
    if missing:
        raise InputError(
            f"every finger must have a pad at its tip; {_quoted(missing)} is missing, "
            f"got {_quoted(pads)}"
        )
    _check_begins("pad", pads, (*fingers, PALM))


def _check_begins(kind: str, names: tuple[str, ...], parts: tuple[str, ...]) -> None:
    unknown = [name for name in names if not name.startswith(parts)]
    if unknown:
        raise InputError(
            f"{kind} {_quoted(unknown)} has no finger: names of {kind}s must begin with "
            f"{_quoted(parts)}"
        )


def _quoted(names: tuple[str, ...] | list[str]) -> str:
    return ", ".join(repr(name) for name in names) or "none"
