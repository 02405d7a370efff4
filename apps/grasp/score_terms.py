"""What the terms of a grasp's score mean, in words for people who read the demo's page."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

SCORE_WORDS: dict[str, str] = {
    "width": "the hand opens that wide with room to spare",
    "height": "it is tall enough to be wrapped",
    "weight": "it is light enough for fingertips",
    "fallback": "it is wrapped or pinched, as tips that close on anything hold less surely",
    "purpose": "this kind of grasp suits what the object is lifted for",
    "certainty": "its sides were seen, not guessed",
    "stands": "it does not topple when touched",
    "side": "fingers close across its short side",
    "palm": "the palm comes close enough to help",
    "hold": "the fingertips reach far enough below its top",
    "room": "fingers have free space beside its neighbours",
    "opening": "the hand opens wide enough to forgive errors",
    "variant": "its usual place for the hand was free",
}
"""By term, what is so where the term is 1."""

SIZES = (
    "An object's size is that of its fitted solid along the solid's own three axes; beside a grasp "
    "stand the sizes that the hand meets: width between fingers and thumb × length along the row "
    "of fingers, and height as it lies."
)
"""Which size is which."""


def score_words(terms: Mapping[str, float]) -> str:
    """Give a score's terms as HTML, each with its meaning as hover text."""
    return " × ".join(
        f'<span class="term" title="{escape(SCORE_WORDS.get(name, ""), quote=True)}">'
        f"{escape(name)} {value:.2f}</span>"
        for name, value in terms.items()
    )


def score_legend(names: Iterable[str]) -> str:
    """Explain scores and the given terms in one paragraph of HTML, in their usual order."""
    wanted = set(names)
    told = "; ".join(
        f"<b>{name}</b> {escape(words)}" for name, words in SCORE_WORDS.items() if name in wanted
    )
    means = f" A term is 1 where all is well: {told}." if told else ""
    return (
        "Of all grasps the one with the highest score is taken, the product of its terms from 0 "
        f"to 1.{means}"
    )
