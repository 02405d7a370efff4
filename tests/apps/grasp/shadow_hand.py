"""The Shadow hand of `gymnasium-robotics` (an optional extra), and how its fingers close."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import FingerDescription, HandDescription
from eyehand.data_synth.cell.spec_assembly import prepare_for_attachment
from eyehand.errors import InputError

PACKAGE = "gymnasium_robotics"
"""Only its files are read: the package itself is never imported."""
PALM_SITE = "palm"
"""The hand frame, which is added to the file's palm."""
PREFIX = "robot0:"
"""What stands before the names in the file."""
PALM_ORIGIN = (0.022, -0.0111, 0.078)
"""Of the hand frame in the palm's body, m: on the palm's face, between index and middle finger,
where the fingers bent at the knuckles meet the thumb that is swung before the palm."""
PALM_AXES = (0.5, 0.5, 0.5, -0.5)
"""w, x, y, z of the hand frame in the palm's body: z out of the palm, x from knuckles to wrist."""
SERVO_STIFFNESS = 10.0
"""Of the fingers' position servos, Nm/rad, within the file's own limits of torque: with its
1 Nm/rad a finger half closed can press with half its torque only."""


def _finger(name: str, letters: str) -> FingerDescription:
    """A finger that stands out of the palm and closes from the knuckle."""
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
"""Fingers and thumb facing one another before the palm: the thumb sweeps about its base, its other
joints swung out as far as they go."""


def shadow_hand_path() -> Path | None:
    """Path of the installed hand's MJCF; None where the package is not installed."""
    found = importlib.util.find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        return None
    path = Path(found.submodule_search_locations[0]) / "envs" / "assets" / "hand" / "reach.xml"
    return path if path.is_file() else None


def shadow_hand() -> Any:
    """Describe the Shadow hand alone: an `MjSpec`, its forearm at the origin, with a site "palm".

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
    # The file is a scene: besides the hand it holds a floor, targets and a lamp.
    for thing in (*spec.worldbody.bodies, *spec.worldbody.geoms, *spec.worldbody.lights):
        if thing.name != mount.name:
            spec.delete(thing)
    prepare_for_attachment(spec)
    mount.pos = [0.0, 0.0, 0.0]
    spec.body(f"{PREFIX}palm").add_site(name=PALM_SITE, pos=PALM_ORIGIN, quat=PALM_AXES, group=4)
    for motor in spec.actuators:
        motor.gainprm[0], motor.biasprm[1] = SERVO_STIFFNESS, -SERVO_STIFFNESS
    return spec
