"""Grasps of the hand on solids at a known pose, with each prototype."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.scenes import TabletopObject
from eyehand.perception.superquadric import Superquadric

from .hand_bench import HandBenchOptions, bench_grasp

EXPONENTS = {"box": (0.1, 0.1), "cylinder": (0.1, 1.0), "sphere": (1.0, 1.0), "ellipsoid": (1, 1)}


def solid(kind, width, length, height, mass):
    half = np.array([width, length, height]) / 2
    pose = RigidTransform.from_translation([0, 0, height / 2])
    shape = Superquadric(half, EXPONENTS[kind], pose, kind)
    return TabletopObject(f"{kind}_0", shape, mass, (0.8, 0.3, 0.2))


@pytest.mark.parametrize(
    ("item", "prototype", "approach"),
    [
        (solid("box", 0.060, 0.080, 0.020, 0.04), "precision", "top"),
        (solid("box", 0.020, 0.040, 0.040, 0.03), "pincer", "top"),
        (solid("sphere", 0.075, 0.075, 0.075, 0.10), "power", "top"),
    ],
)
def test_each_prototype_lifts_object(item, prototype, approach):
    result = bench_grasp(item, prototype, approach)

    assert result, result
    assert result.slip_mm < 2.0
    assert result.warnings == 0


@pytest.mark.parametrize(
    ("item", "approach"),
    [
        (solid("cylinder", 0.065, 0.065, 0.140, 0.25), "side"),
        (solid("cylinder", 0.080, 0.080, 0.150, 0.35), "side"),
        (solid("sphere", 0.070, 0.070, 0.070, 0.10), "top"),
    ],
)
def test_power_grasp_encloses_round_object(item, approach):
    result = bench_grasp(item, "power", approach)

    assert result, result
    assert result.palm
    assert result.phalanges >= 7
    assert result.thumb >= 1
    assert result.curl > 0.6


def test_power_grasp_without_palm_contact_holds_with_fingers():
    # The finger roots touch the rim, so the flat top stays 12 mm from the palm.
    result = bench_grasp(solid("cylinder", 0.070, 0.070, 0.100, 0.19), "power", "top")

    assert result, result
    assert not result.palm
    assert result.curl > 0.6


def test_grasp_without_object_ends_empty():
    item = solid("sphere", 0.03, 0.03, 0.03, 0.01)
    far = replace(HandBenchOptions(), shift=(0.2, 0.2, 0.0))
    result = bench_grasp(item, "precision", "top", far)

    assert not result
    assert result.state == "empty"
