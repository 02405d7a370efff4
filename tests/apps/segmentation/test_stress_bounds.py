"""The segmentation holds every bound of its stress test, and answers cleanly past breaking."""

import pytest

from eyehand.apps.bench import Sweep, run_sweep
from eyehand.apps.segmentation.stress_sweeps import segmentation_sweeps
from eyehand.perception import segment

SEEDS = {"repeat": (0,)}
"""Scenes of sweeps that look at each many times."""


@pytest.mark.parametrize("sweep", segmentation_sweeps(), ids=lambda sweep: sweep.name)
def test_the_bound_holds_and_what_comes_after_it_is_a_clean_answer(sweep: Sweep):
    # Easiest, bound and hardest value stand for what lies between.
    result = run_sweep(sweep.shortened(), SEEDS.get(sweep.name, (0, 1)), segment)
    assert result.faults == ()
