"""Test that the segmentation holds every stress bound and gives valid answers past it."""

import pytest

from eyehand.apps.bench import Sweep
from eyehand.apps.bench.sweep import run_sweep
from eyehand.apps.segmentation.stress import SEGMENTATION_SWEEPS
from eyehand.perception import segment

SEEDS = {"repeat": (0,)}
"""Seeds of sweeps that run each scene many times."""


@pytest.mark.slow
@pytest.mark.parametrize("sweep", SEGMENTATION_SWEEPS, ids=lambda sweep: sweep.name)
def test_bound_holds_and_answers_past_it_are_valid(sweep: Sweep):
    # Only the easiest value, the bound and the hardest value are run.
    result = run_sweep(sweep.shortened(), SEEDS.get(sweep.name, (0, 1)), segment)
    assert result.faults == ()
