"""Objects that stand between the open fingers and stop them while they close."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from jaw_scenes import box, can, scene_of

from eyehand.grasping import load_hand
from eyehand.grasping.jaws.best_first import _closing_clearance, scene_tests
from eyehand.grasping.jaws.candidates import Candidates
from eyehand.grasping.jaws.kernels import FAR
from eyehand.grasping.jaws.options import JawOptions
from eyehand.grasping.jaws.surface_model import object_surface

PANDA = load_hand("panda")
DOWN = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""Rotation of a grasp from above that closes along y."""


@pytest.mark.parametrize(
    ("gap", "low", "high"),
    [(None, 0.02, 0.02), (0.004, -0.02, -0.004), (0.01, -0.02, -0.004), (0.09, 0.01, 0.02)],
)
def test_clearance_counts_what_fingers_meet_while_they_close(gap, low, high):
    """A post of 12 mm stands beside a box of 20 mm, at this gap; the hand opens 80 mm."""
    items = [box((0.05, 0.02, 0.1))]
    if gap is not None:
        items.append(can(0.006, 0.08, (0.0, 0.016 + gap), label=2))
    scene = scene_of(*items)
    surfaces: Any = [object_surface(item, scene) for item in items]
    tests = scene_tests(scene, surfaces, PANDA, JawOptions())
    tip = np.array([[0.0, 0.0, 0.06]])
    part: Any = SimpleNamespace(
        candidates=Candidates(DOWN[None], tip, np.zeros(1, np.int64), np.full(1, np.inf)),
        contact=SimpleNamespace(width=np.array([0.02])),
        opening=np.array([0.08]),
    )
    assert low <= (found := _closing_clearance(part, np.array([FAR]), tests)[0]) <= high
    # A smaller clearance of the open hand stays.
    assert _closing_clearance(part, np.array([-0.015]), tests)[0] == pytest.approx(
        min(found, -0.015)
    )
