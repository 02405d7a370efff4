"""Hands with driven joints hold solids with each prototype."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import DESCRIPTION_SUFFIX, grasp_robot
from eyehand.data_synth.cell.hand_description import read_description
from eyehand.errors import InputError
from eyehand.perception.superquadric import Superquadric

from . import shadow_hand
from .air_grasp import grasp_in_air
from .shadow_hand import SHADOW_HAND

SERVO_HAND = Path(grasp_robot.__file__).parent / "assets" / "servo_hand.xml"
EXPONENTS = {"box": (0.1, 0.1), "cylinder": (0.1, 1.0), "sphere": (1.0, 1.0)}

needs_shadow = pytest.mark.skipif(
    shadow_hand.shadow_hand_path() is None,
    reason="gymnasium-robotics with the files of the Shadow hand is not installed",
)


def solid(kind, width, length, height):
    half = np.array([width, length, height]) / 2
    return Superquadric(half, EXPONENTS[kind], RigidTransform.identity(), kind)


def servo_hand():
    return import_mujoco().MjSpec.from_file(str(SERVO_HAND)), read_description(
        SERVO_HAND.with_suffix(DESCRIPTION_SUFFIX)
    )


@needs_shadow
@pytest.mark.parametrize(
    ("prototype", "facing", "shape", "mass"),
    [
        ("pincer", "down", solid("box", 0.025, 0.030, 0.040), 0.05),
        ("precision", "down", solid("sphere", 0.05, 0.05, 0.05), 0.08),
        ("power", "side", solid("cylinder", 0.055, 0.055, 0.11), 0.25),
    ],
)
def test_shadow_hand_holds_with_each_prototype(prototype, facing, shape, mass):
    held = grasp_in_air(
        shadow_hand.shadow_hand(), SHADOW_HAND, "palm", shape, mass, prototype, facing=facing
    )

    assert held, held
    assert held.thumb
    assert held.creep_mm < 1.0
    assert held.warnings == 0
    assert held.fingers == 1 if prototype == "pincer" else held.fingers >= 2
    assert prototype != "power" or held.pads >= 8


@pytest.mark.parametrize(
    ("prototype", "facing", "shape", "mass"),
    [
        ("pincer", "down", solid("box", 0.025, 0.060, 0.040), 0.05),
        ("precision", "down", solid("box", 0.05, 0.08, 0.04), 0.10),
        ("power", "side", solid("cylinder", 0.07, 0.07, 0.11), 0.25),
    ],
)
def test_servo_hand_holds_with_each_prototype(prototype, facing, shape, mass):
    spec, description = servo_hand()
    held = grasp_in_air(spec, description, "palm", shape, mass, prototype, facing=facing)

    assert held, held
    assert held.creep_mm < 1.0
    assert held.warnings == 0


def test_heavy_object_falls():
    spec, description = servo_hand()
    held = grasp_in_air(spec, description, "palm", solid("sphere", 0.05, 0.05, 0.05), 8.0, "pincer")

    assert not held
    assert held.moved_mm > 100.0


def test_wide_object_is_refused():
    spec, description = servo_hand()
    with pytest.raises(InputError, match="200 mm wide"):
        grasp_in_air(spec, description, "palm", solid("box", 0.2, 0.05, 0.05), 0.1, "power")


def test_missing_shadow_hand_package_names_extra(monkeypatch):
    monkeypatch.setattr(shadow_hand, "PACKAGE", "no_such_package_is_installed")

    assert shadow_hand.shadow_hand_path() is None
    with pytest.raises(InputError, match=r"eyehand\[robots\]"):
        shadow_hand.shadow_hand()


@pytest.mark.parametrize("prototype", ["pincer", "precision", "power"])
def test_servo_hand_without_object_is_empty(prototype):
    spec, description = servo_hand()
    crumb = solid("sphere", 0.002, 0.002, 0.002)
    held = grasp_in_air(spec, description, "palm", crumb, 1e-4, prototype, hold=0.1)

    assert not held, held
    assert held.state == "empty"


@needs_shadow
def test_shadow_hand_without_object_is_empty():
    crumb = solid("sphere", 0.002, 0.002, 0.002)
    spec = shadow_hand.shadow_hand()
    held = grasp_in_air(spec, SHADOW_HAND, "palm", crumb, 1e-4, "power", hold=0.1)

    assert held.state == "empty", held
