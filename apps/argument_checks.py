"""Checks of all arguments of a command by their types, before the command is imported or runs."""

from __future__ import annotations

import errno
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

INTEGER_BOUND = 1 << 63
"""Integers at or above this do not fit the 64-bit columns and counters that seeds end in."""


def check_arguments(_app: Any, _commands: tuple[str, ...], arguments: Any) -> None:
    """Reject values that no command can use. The signature is that of a configuration of cyclopts.

    Checked are fractions and too large numbers for integers, and FIFOs, sockets and devices for
    files and folders: to open one could wait forever.

    Raises
    ------
    InputError
        If a value is rejected.
    """
    for argument in arguments:
        kinds = set(_kinds(argument.hint))
        for token in argument.tokens:
            name = token.keyword or argument.name
            if int in kinds and not kinds & {float, str}:
                _check_integer(name, token.value)
            if kinds & {Path, str}:
                _check_path(name, token.value, is_path=Path in kinds)


def is_number(text: str) -> bool:
    """Return whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _check_integer(name: str, text: str) -> None:
    from eyehand.errors import InputError

    if "." in text and is_number(text) and not float(text).is_integer():
        raise InputError(f"{name} must be a whole number, got {text}")
    # A float cannot represent 2**63 - 1, so whole numbers are compared as integers.
    try:
        value = int(text)
    except ValueError:
        value = float(text) if is_number(text) else 0.0
    if abs(value) >= INTEGER_BOUND:
        raise InputError(f"{name} must be between -2**63 and 2**63, got {text}")


def _check_path(name: str, text: str, *, is_path: bool) -> None:
    """Reject a special file. A text that may be a name of another kind can have any length."""
    from eyehand.errors import InputError

    try:
        mode = Path(text).stat().st_mode
    except ValueError:
        return
    except OSError as error:
        if is_path and error.errno == errno.ENAMETOOLONG:
            raise InputError(f"{name}: {error.strerror}: {text}") from error
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        kind = "a FIFO" if stat.S_ISFIFO(mode) else "a socket or device"
        raise InputError(f"{name} {text}: it is {kind}, expected a file or folder")


def _kinds(hint: Any) -> Iterator[Any]:
    """Yield all types that a type hint consists of."""
    inner = get_args(hint)
    if not inner:
        yield hint
    for part in inner:
        yield from _kinds(part)
