"""What the names of a hand's parts mean: which finger opposes, which pinches, which drives wrap."""

from __future__ import annotations

from eyehand.errors import InputError

THUMB = "thumb"
"""The finger that opposes all others, and the drive that moves it."""
PINCER_FINGER = "middle"
"""The finger that pinches against the thumb, and its drive; without it all fingers pinch."""
WRAPS = ("wrap", "thumb_wrap")
"""Drives that bend the outer joints of the fingers and of the thumb around an object."""
TIP = "distal"
"""How the names of the tips' pads end."""
PALM = "palm"
"""How the names of the palm's pads begin."""


def check_names(
    drives: tuple[str, ...],
    joints: tuple[str, ...],
    pads: tuple[str, ...],
    fingers: tuple[str, ...],
) -> None:
    """Check that the names of a hand tell what closing needs to know of it.

    Parameters
    ----------
    drives, joints, pads, fingers
        Names, as :class:`~.hand_model.HandModel` has them.

    Raises
    ------
    InputError
        If one of its rules is broken: which, by what, and what would be right.
    """
    for kind, names in (("drives", drives), ("joints", joints), ("pads", pads)):
        _check_unlike(kind, names)
    _check_fingers(fingers)
    _check_drives(drives, fingers)
    _check_pads(pads, fingers)


def _check_unlike(kind: str, names: tuple[str, ...]) -> None:
    twice = sorted({name for name in names if not name or names.count(name) > 1})
    if twice:
        raise InputError(
            f"{kind} of a hand must have names unlike one another, {_told(twice)} is not one; "
            f"got {_told(names)}"
        )


def _check_fingers(fingers: tuple[str, ...]) -> None:
    _check_unlike("fingers", fingers)
    if len(fingers) < 2 or fingers[-1] != THUMB:
        raise InputError(
            f"fingers of a hand must be one or more, and last {THUMB!r}, which opposes them; "
            f"got {_told(fingers)}"
        )
    for name in fingers:
        begins = [other for other in (*fingers, PALM) if other != name and name.startswith(other)]
        if begins or name in WRAPS:
            raise InputError(
                f"finger {name!r} must have another name: {_told(begins or WRAPS)} "
                f"{'begins it, and ' if begins else 'are drives, and '}"
                "pads and joints are a finger's whose name theirs begins with"
            )


def _check_drives(drives: tuple[str, ...], fingers: tuple[str, ...]) -> None:
    valid = (
        f"valid are {_told(fingers)} (moves that finger), {_told(WRAPS)} (bend outer joints), and "
        "any other name for a drive of all fingers that have none of their own"
    )
    if THUMB not in drives:
        raise InputError(f"one drive must be {THUMB!r}; got {_told(drives)}; {valid}")
    shared = [name for name in drives if name not in (*fingers, *WRAPS)]
    alone = [name for name in fingers if name not in drives]
    if alone and not shared:
        raise InputError(f"no drive moves {_told(alone)}; got {_told(drives)}; {valid}")
    if shared and not alone:
        raise InputError(
            f"drive {_told(shared)} moves nothing, as every finger has its own; {valid}"
        )


def _check_pads(pads: tuple[str, ...], fingers: tuple[str, ...]) -> None:
    tips = tuple(f"{name}_{TIP}" for name in fingers)
    missing = [name for name in tips if name not in pads]
    if missing:
        raise InputError(
            f"every finger must have a pad at its tip; {_told(missing)} is missing among "
            f"{_told(pads)}"
        )
    strange = [name for name in pads if not name.startswith((*fingers, PALM))]
    if strange:
        raise InputError(
            f"pad {_told(strange)} is nobody's: names of pads begin with {_told((*fingers, PALM))}"
        )


def _told(names: tuple[str, ...] | list[str]) -> str:
    return ", ".join(repr(name) for name in names) or "none"
