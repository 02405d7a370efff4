"""Settings of a stage's options for its chart: each dial alone, and some in combination."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Generic, TypeVar

Options = TypeVar("Options")
DEFAULT = "default"
"""Name of the setting with all dials at their defaults."""
BARE = "bare"
"""Name of the setting that switches off all optional steps."""


@dataclass(frozen=True)
class DialBoard(Generic[Options]):
    """All dials of a stage."""

    default: Options
    """Default options, a frozen dataclass."""
    dials: Mapping[str, tuple[Any, ...]]
    """Fields of the options and the values to try."""
    crosses: tuple[Mapping[str, tuple[Any, ...]], ...] = ()
    """Combinations: every value with every other."""
    quick: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    """Dials of a quick chart, each alone."""
    words: Mapping[tuple[str, Any], str] = field(default_factory=dict)
    """Names of values for the chart: (field, value) → word; default: field and value."""
    bare: Mapping[str, Any] = field(default_factory=dict)
    """Values that together are called BARE."""

    def setting(self, dials: Mapping[str, Any] | None = None) -> DialSetting[Options]:
        """Return the setting with these values; default values are left out."""
        wanted = dials or {}
        turned = {key: wanted[key] for key in self.dials if key in wanted}
        default = self.default
        return DialSetting(
            self, {key: v for key, v in turned.items() if v != getattr(default, key)}
        )

    def settings(self, *, quick: bool = False) -> list[DialSetting[Options]]:
        """Return all different settings. Those that change fewer dials come first."""
        chosen: list[dict[str, Any]] = [{}]
        for key, values in (self.quick if quick else self.dials).items():
            chosen += [{key: value} for value in values]
        for cross in () if quick else self.crosses:
            chosen += [dict(zip(cross, values, strict=True)) for values in product(*cross.values())]
        unique: dict[Options, DialSetting[Options]] = {}
        for dials in chosen:
            setting = self.setting(dials)
            unique.setdefault(setting.options, setting)
        return sorted(unique.values(), key=lambda setting: len(setting.dials))


@dataclass(frozen=True)
class DialSetting(Generic[Options]):
    """One setting of all dials."""

    board: DialBoard[Options]
    dials: Mapping[str, Any]
    """Values that differ from the default, by field name."""

    @property
    def name(self) -> str:
        """Difference from the default, in words."""
        bare = self.board.bare
        stripped = bool(bare) and all(self.dials.get(key) == v for key, v in bare.items())
        words = [
            self.board.words.get((key, value), f"{key.replace('_', ' ')} {value}")
            for key, value in self.dials.items()
            if not (stripped and key in bare)
        ]
        return ", ".join([*words, *([BARE] if stripped else [])]) or DEFAULT

    @property
    def options(self) -> Options:
        """Options with these dials turned."""
        return replace(self.board.default, **self.dials)  # pyright: ignore[reportArgumentType]

    def all_dials(self) -> dict[str, Any]:
        """Return every dial with its value, so that later changes of defaults have no effect."""
        options = self.options
        return {key: getattr(options, key) for key in self.board.dials}
