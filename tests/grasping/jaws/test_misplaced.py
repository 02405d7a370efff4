"""The term of a misplaced hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jaw_scenes import box, can, scene_of

from eyehand.grasping import JawOptions, load_hand, plan_grasps
from eyehand.grasping.jaws.candidates import solid_candidates
from eyehand.grasping.jaws.contacts import centred_contacts
from eyehand.grasping.jaws.depth_error import held_probability
from eyehand.grasping.jaws.misplaced import misplaced_term
from eyehand.grasping.jaws.scored import ScoredCandidates
from eyehand.grasping.jaws.surface_model import object_surface

PANDA = load_hand("panda")
UP = np.array([0.0, 0.0, 1.0])


def tall_box():
    """Return the candidates of a box of 30 x 30 x 120 mm, and its surface."""
    scene = scene_of(box((0.03, 0.03, 0.12)))
    surface = object_surface(scene.objects[0], scene)
    assert surface is not None
    found = solid_candidates(surface.solids[0], 0, PANDA, UP, JawOptions())
    found, contact = centred_contacts(found, surface, scene.support, PANDA)
    count = len(found)
    none = np.zeros((count, 2))
    opening = np.full(count, PANDA.stroke)
    return ScoredCandidates(found, contact, opening, {}, none, none, none[:, 0]), surface


def test_hand_in_place_costs_nothing():
    scored, surface = tall_box()
    term = misplaced_term(scored, surface, PANDA, JawOptions(calibration_error=0.0))
    np.testing.assert_array_equal(term, 1.0)
    assert len(misplaced_term(scored.take(slice(0)), surface, PANDA, JawOptions())) == 0


def test_term_is_the_mean_of_five_places():
    scored, surface = tall_box()
    options = JawOptions(calibration_error=0.0061)
    places = []
    for axis, sign in ((1, 0), (1, 1), (1, -1), (2, 1), (2, -1)):
        tip = scored.candidates.tip + sign * 1.5 * 0.0061 * scored.candidates.rotation[:, :, axis]
        moved = scored.candidates.at(tip)
        places.append(held_probability(moved, scored.opening, surface, PANDA, options))
    expected = np.clip(np.mean(places, axis=0) / np.maximum(places[0], 1e-6), 0.0, 1.0)
    term = misplaced_term(scored, surface, PANDA, options)
    np.testing.assert_allclose(term, expected, atol=1e-12)
    assert term.min() < 0.9
    assert term.max() > 0.9


def test_pads_that_barely_overlap_the_object_lose_most():
    """A deep grasp tolerates a hand that stops too high, one at the top edge does not."""
    scored, surface = tall_box()
    above = scored.candidates.rotation[:, 2, 2] < -0.99
    deep = scored.take(above)
    tip = deep.candidates.tip.copy()
    tip[:, 2] = 0.10
    low = replace(deep, candidates=deep.candidates.at(tip))
    high = replace(deep, candidates=deep.candidates.at(tip + 0.012 * UP))
    options = JawOptions(calibration_error=0.005)
    kept = misplaced_term(low, surface, PANDA, options)
    lost = misplaced_term(high, surface, PANDA, options)
    assert len(kept) > 0
    assert kept.min() > 0.95
    assert lost.max() < 0.9


@pytest.mark.parametrize("error", [0.0, 0.003, 0.008])
def test_success_falls_with_the_calibration_error(error):
    scene = scene_of(can(0.02, 0.05))
    less = plan_grasps(scene, PANDA, JawOptions(calibration_error=error))
    more = plan_grasps(scene, PANDA, JawOptions(calibration_error=error + 0.004))
    assert less
    assert more
    assert less[0].success > more[0].success


def test_small_error_of_the_scale_counts_as_a_misplaced_hand():
    scene = scene_of(can(0.02, 0.05))
    exact, small, large = (
        plan_grasps(scene, PANDA, JawOptions(depth_error=error))[0].terms
        for error in (0.0, 0.009, 0.02)
    )
    assert exact["depth_error"] == small["depth_error"] == 1.0
    assert small["misplaced"] < exact["misplaced"]
    assert large["depth_error"] < 1.0
