"""The Shadow hand of `gymnasium-robotics`, an optional extra, with a description of its fingers."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import FingerDescription, HandDescription
from eyehand.data_synth.cell.spec_assembly import prepare_for_attachment
from eyehand.errors import InputError

PACKAGE = "gymnasium_robotics"
"""The package of the hand. Only its files are read; it is not imported."""
PALM_SITE = "palm"
"""Name of the hand frame, which is added to the palm in the file."""
PREFIX = "robot0:"
"""Prefix of the names in the file."""
PALM_ORIGIN = (0.022, -0.0111, 0.078)
"""Origin of the hand frame in the palm's body, m. It is on the palm's face between index and middle
finger, where the bent fingers meet the opposed thumb."""
PALM_AXES = (0.5, 0.5, 0.5, -0.5)
"""Quaternion (w, x, y, z) of the hand frame in the palm's body. z points out of the palm, x from
the knuckles to the wrist."""
SERVO_STIFFNESS = 10.0
"""Stiffness of the fingers' position servos, Nm/rad. The torque limits of the file still apply.
With the 1 Nm/rad of the file, a half-closed finger presses with only half its torque."""


def _finger(name: str, letters: str) -> FingerDescription:
    """Return a finger that closes from the knuckle."""
    return FingerDescription(
        name,
        {
            f"{PREFIX}{letters}J2": (0.85, 1.55),
            f"{PREFIX}{letters}J1": (0.10, 0.60),
            # The file couples the outer joints by a tendon.
            f"{PREFIX}{letters}J0": (0.114, 0.685),
        },
        tuple(f"{PREFIX}C_{letters.lower()}{bone}" for bone in ("proximal", "middle", "distal")),
    )


SHADOW_HAND = HandDescription(
    fingers=(
        _finger("index", "FF"),
        _finger("middle", "MF"),
        _finger("ring", "RF"),
        _finger("little", "LF"),
        FingerDescription(
            "thumb",
            {
                f"{PREFIX}THJ4": (-0.30, 0.95),
                f"{PREFIX}THJ3": (1.20, 1.20),
                f"{PREFIX}THJ2": (0.20, 0.20),
                f"{PREFIX}THJ1": (0.50, 0.50),
                f"{PREFIX}THJ0": (-0.02, -0.02),
            },
            tuple(f"{PREFIX}C_th{bone}" for bone in ("proximal", "middle", "distal")),
        ),
    ),
    palm=tuple(f"{PREFIX}C_{geom}" for geom in ("palm0", "palm1", "lfmetacarpal")),
    still={
        f"{PREFIX}{joint}": 0.0
        for joint in ("WRJ1", "WRJ0", "FFJ3", "MFJ3", "RFJ3", "LFJ3", "LFJ4")
    },
)
"""Fingers and thumb oppose each other in front of the palm. The thumb turns about its base; its
other joints stay at their outer limits."""


def shadow_hand_path() -> Path | None:
    """Return the path of the hand's MJCF; None if the package is not installed."""
    found = importlib.util.find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        return None
    path = Path(found.submodule_search_locations[0]) / "envs" / "assets" / "hand" / "reach.xml"
    return path if path.is_file() else None


def shadow_hand() -> Any:
    """Return the `MjSpec` of the Shadow hand, with its forearm at the origin and a site "palm".

    Raises
    ------
    InputError
        If `gymnasium-robotics` is not installed.
    """
    mujoco = import_mujoco()
    path = shadow_hand_path()
    if path is None:
        raise InputError(
            "the Shadow hand comes with gymnasium-robotics, which is not installed: "
            "pip install 'eyehand[robots]'"
        )
    spec = mujoco.MjSpec.from_file(str(path))
    mount = spec.body(f"{PREFIX}hand mount")
    # The file is a scene. It also holds a floor, targets and a lamp.
    for thing in (*spec.worldbody.bodies, *spec.worldbody.geoms, *spec.worldbody.lights):
        if thing.name != mount.name:
            spec.delete(thing)
    prepare_for_attachment(spec)
    mount.pos = [0.0, 0.0, 0.0]
    spec.body(f"{PREFIX}palm").add_site(name=PALM_SITE, pos=PALM_ORIGIN, quat=PALM_AXES, group=4)
    for motor in spec.actuators:
        motor.gainprm[0], motor.biasprm[1] = SERVO_STIFFNESS, -SERVO_STIFFNESS
    return spec
