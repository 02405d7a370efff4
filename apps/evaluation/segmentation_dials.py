"""The settings that the segmentation's chart shows: every dial alone, the main ones crossed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING

from eyehand.perception import SegmentationOptions

if TYPE_CHECKING:
    from collections.abc import Mapping

DIALS: dict[str, tuple[int | bool, ...]] = {
    "stride": (1, 2, 3, 4),
    "window": (5, 7, 9, 11, 13),
    "threads": (1, 2),
    "median": (True, False),
    "shift_windows": (True, False),
    "join_open": (True, False),
    "join_occluded": (True, False),
    "colour_edges": (True, False),
    "split_solids": (False, True),
}
"""Fields of the options and the values that each is turned to."""
CROSSES: tuple[dict[str, tuple[int | bool, ...]], ...] = (
    {"stride": (1, 2, 3, 4), "window": (5, 7, 9, 11, 13)},
    {"stride": (1, 2, 3, 4), "threads": (2,), "window": (7, 9, 11)},
    {"stride": (1, 2, 3, 4), "shift_windows": (False,), "window": (5, 9), "threads": (1, 2)},
    {
        "stride": (1, 2, 3, 4),
        "median": (False,),
        "shift_windows": (False,),
        "join_open": (False,),
        "join_occluded": (False,),
        "colour_edges": (False,),
        "threads": (1, 2),
    },
)
"""What is turned together: the stride makes the pixels few and so asks for other windows, threads
gain on large images only, and with every stage off the least time shows."""
QUICK: dict[str, tuple[int | bool, ...]] = {
    "stride": (1, 2, 4),
    "window": (5,),
    "threads": (2,),
    "shift_windows": (False,),
}
"""Dials of a quick look."""
WORDS = {
    ("median", False): "no median",
    ("shift_windows", False): "no shift",
    ("join_open", False): "hollows apart",
    ("join_occluded", False): "occluded apart",
    ("colour_edges", False): "no colour",
    ("split_solids", True): "split solids",
    ("median", True): "median",
    ("shift_windows", True): "shift",
    ("join_open", True): "hollows joined",
    ("join_occluded", True): "occluded joined",
    ("colour_edges", True): "colour",
    ("split_solids", False): "solids whole",
}
"""What a switched stage is called in the chart."""
BARE = "bare"
"""What it is called when every stage that can be switched off is off."""
DEFAULT = "default"


@dataclass(frozen=True)
class DialSetting:
    """One setting of all dials."""

    dials: Mapping[str, int | bool] = field(default_factory=dict)
    """Those that are not at their default, by field name."""

    @property
    def name(self) -> str:
        """How it differs from the default, in words."""
        stages = {key: value for key, value in self.dials.items() if isinstance(value, bool)}
        words = []
        for key, value in self.dials.items():
            if key == "threads":
                words.append(f"{value} thread{'s' if value > 1 else ''}")
            elif key not in stages:
                words.append(f"{key} {value}")
        if set(stages) >= _switchable() and not any(stages.values()):
            words.append(BARE)
        else:
            words += [WORDS[key, value] for key, value in stages.items()]
        return ", ".join(words) or DEFAULT

    @property
    def options(self) -> SegmentationOptions:
        """Options with these dials turned."""
        return replace(SegmentationOptions(), **self.dials)

    def all_dials(self) -> dict[str, int | bool]:
        """Every dial with its value, so that other defaults one day change nothing."""
        options = self.options
        return {key: getattr(options, key) for key in DIALS}


def dial_settings(*, quick: bool = False) -> list[DialSetting]:
    """List settings, none twice, those that turn fewer dials first: the default is the first."""
    chosen = [{}]
    for key, values in (QUICK if quick else DIALS).items():
        chosen += [{key: value} for value in values]
    for cross in () if quick else CROSSES:
        chosen += [dict(zip(cross, values, strict=True)) for values in product(*cross.values())]
    default = SegmentationOptions()
    unique: dict[SegmentationOptions, DialSetting] = {}
    for dials in chosen:
        turned = {key: dials[key] for key in DIALS if key in dials}
        turned = {key: value for key, value in turned.items() if value != getattr(default, key)}
        setting = DialSetting(turned)
        unique.setdefault(setting.options, setting)
    return sorted(unique.values(), key=lambda setting: len(setting.dials))


def _switchable() -> set[str]:
    """Stages that are on by default."""
    default = SegmentationOptions()
    return {key for key in DIALS if getattr(default, key) is True}
