"""Class and half of each development mesh, by its name without numbers and suffixes."""

from __future__ import annotations

import re
import zlib
from typing import Literal

MeshClass = Literal["box", "can", "bottle", "vessel", "tool", "rod", "fruit", "other"]
"""Class of a household object. A vessel is open at the top: a bowl or a mug."""
Half = Literal["settings", "report"]
"""Settings are chosen on one half of the meshes. Figures come from the other half."""
CLASS_NAMES: tuple[MeshClass, ...] = (
    *("box", "can", "bottle", "vessel"),
    *("tool", "rod", "fruit", "other"),
)

_SETTINGS: dict[MeshClass, str] = {
    "box": "003_cracker_box Amicelli DropsCherry MilkDrinkVanilla PotatoeStarch YellowSaltCube2 "
    "clif_crunch_chocolate_chip BlueSaltCube InstantTomatoSoup cinnamon_toast_crunch "
    "hersheys_cocoa",
    "can": "ChoppedTomatoes InstantIceCoffee OrangeMarmelade can_poisson_002 "
    "YellowSaltCylinderSmall",
    "bottle": "006_mustard_bottle Shampoo 114509277e76e413c8724d5673a063a6 "
    "detergent_bottle_poisson_002",
    "vessel": "025_mug bowl_poisson_030",
    "tool": "035_power_drill power_drill 037_scissors",
    "rod": "flashlight_poisson_006",
    "fruit": "apple",
    "other": "toy_poisson_003",
}
_REPORT: dict[MeshClass, str] = {
    "box": "008_pudding_box CoughDropsBerries JamSugar OrgHerbTea RuskWholemeal TomatoHerbSauce "
    "canon_ack_e10_box dove_beauty_cream_bar CoughDropsHoney band_aid_sheer_strips "
    "eating_right_for_healthy_living_apple",
    "can": "002_master_chef_can HerbSalt progresso_new_england_clam_chowder RavioliLarge "
    "jar_poisson_001",
    "bottle": "pepto_bismol suave_sweet_guava_nectar_body_wash HamburgerSauce Sprudelflasche "
    "spray_can_poisson_000 white_rain_sensations_apple_blossom_hydrating_body_wash",
    "vessel": "024_bowl mug",
    "tool": "051_large_clamp screwdriver_poisson_006",
    "rod": "040_large_marker",
    "fruit": "011_banana",
    "other": "light_bulb_poisson_000 tape_poisson_004",
}
_HALVES: dict[Half, dict[MeshClass, str]] = {"settings": _SETTINGS, "report": _REPORT}
_KNOWN: dict[str, tuple[MeshClass, Half]] = {
    name: (kind, half)
    for half, table in _HALVES.items()
    for kind, names in table.items()
    for name in names.split()
}
_SUFFIX = re.compile(r"(_800_tex)?(_visual|_collision)?$")


def plain_name(stem: str) -> str:
    """Return the name of an object from the stem of its mesh file."""
    return _SUFFIX.sub("", stem)


def class_of(name: str, declared: str | None = None) -> MeshClass:
    """Return the class of an object: as declared in its folder, else as listed here, or other."""
    if declared in CLASS_NAMES:
        return declared
    return _KNOWN.get(name, ("other", "settings"))[0]


def half_of(name: str) -> Half:
    """Return the half of an object: as listed here, else by a hash of its name.

    The lists divide each class. Both drills are in one half, because they may be one object.
    """
    if name in _KNOWN:
        return _KNOWN[name][1]
    return "settings" if zlib.crc32(name.encode()) % 2 else "report"
