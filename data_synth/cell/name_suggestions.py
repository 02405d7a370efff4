"""Suggest valid names for an unknown one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_MAX_NAMES = 8
"""Maximum number of names in a message."""


def suggest_names(name: str, names: Iterable[str]) -> str:
    """List the valid names, the closest first, as the end of a message.

    Examples
    --------
    >>> suggest_names("plam", ["tool", "palm"])
    'there are palm, tool'
    """
    known = [known for known in dict.fromkeys(names) if known]
    near = difflib.get_close_matches(name, known, _MAX_NAMES, cutoff=0.4)
    listed = (near + [known for known in known if known not in near])[:_MAX_NAMES]
    more = ", …" if len(known) > _MAX_NAMES else ""
    return f"there are {', '.join(listed)}{more}" if listed else "there are none with a name"
