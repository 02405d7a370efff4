"""What somebody may have meant by a name that there is not."""

from __future__ import annotations

import difflib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

_MOST = 8
"""Names that a message has room for."""


def suggest_names(name: str, names: Iterable[str]) -> str:
    """Say which names there are, the likeliest first, as the end of a message.

    Examples
    --------
    >>> suggest_names("plam", ["tool", "palm"])
    'there are palm, tool'
    """
    known = [known for known in dict.fromkeys(names) if known]
    near = difflib.get_close_matches(name, known, _MOST, cutoff=0.4)
    told = (near + [known for known in known if known not in near])[:_MOST]
    more = ", …" if len(known) > _MOST else ""
    return f"there are {', '.join(told)}{more}" if told else "there are none with a name"
