"""Explanations of the terms of a grasp score, for the report of the demo."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape

TERM_MEANINGS: dict[str, str] = {
    "width": "the width of the object is in the middle of the range of the prototype",
    "height": "the object is tall enough for the fingers to wrap",
    "weight": "the object is light enough for the fingertips",
    "approach": "the weight does not pull along the pads, as it does from the side",
    "purpose": "the prototype suits the purpose",
    "certainty": "the width is known exactly, and the whole outline of the object was visible",
    "stands": "the object does not topple when touched",
    "side": "the fingers close across the short side",
    "palm": "the palm comes close to the object",
    "hold": "the fingertips reach far below the top of the object",
    "room": "the fingers have clearance to the neighbours",
    "opening": "the opening tolerates position errors",
    "variant": "the default palm placement was free",
    "fallback": "the grasp is a usual one, not one planned for fingers as two jaws",
    "contacts": "two jaws would hold the object there",
    "prototype": "the whole row of fingers holds the object, not one finger",
}
"""Meaning of the value 1, by term."""

SIZE_NOTE = (
    "The size of an object is the extent of its fitted solid along the axes of the solid. The size "
    "at a grasp is the width between fingers and thumb × the length along the row of fingers, and "
    "the height above the table."
)
"""Explanation of the two sizes in the report."""


def score_html(terms: Mapping[str, float]) -> str:
    """Return the terms of a score as HTML, each with its meaning as hover text."""
    return " × ".join(
        f'<span class="term" title="{escape(TERM_MEANINGS.get(name, ""), quote=True)}">'
        f"{escape(name)} {value:.2f}</span>"
        for name, value in terms.items()
    )


def score_legend(names: Iterable[str]) -> str:
    """Explain the score and the given terms in HTML."""
    wanted = set(names)
    meanings = "; ".join(
        f"<b>{name}</b> {escape(meaning)}"
        for name, meaning in TERM_MEANINGS.items()
        if name in wanted
    )
    explained = f" A term is 1 if: {meanings}." if meanings else ""
    return (
        "The grasp with the highest score is selected. The score is the product of its terms, each "
        f"from 0 to 1.{explained}"
    )
