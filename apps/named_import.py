"""Import what a user names as `module:name`: a baseline, or the driver of a sensor."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from eyehand.errors import InputError


def import_named(where: str, what: str) -> Callable[..., Any]:
    """Import a function or class by `module:name`. Modules in the current folder are found too.

    Parameters
    ----------
    where
        Module and name, with a colon between.
    what
        What is imported, for messages.

    Raises
    ------
    InputError
        If the module cannot be imported, or its name does not exist or is not callable.
    """
    module, _, name = where.partition(":")
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError, SyntaxError, ValueError) as error:
        raise InputError(f"cannot import the {what} {where!r}: {error}") from error
    finally:
        sys.path.remove(here)
    if not callable(found):
        raise InputError(f"the {what} {where!r} must be callable, got a {type(found).__name__}")
    return found
