"""Test that the fit holds every stress bound."""

import pytest

from eyehand.apps.bench import Sweep
from eyehand.apps.bench.sweep import run_sweep
from eyehand.apps.fitting.bench.stress import fit_sweeps
from eyehand.apps.fitting.bench.stress_trial import fit_method


@pytest.mark.slow
@pytest.mark.parametrize("sweep", fit_sweeps(), ids=lambda sweep: sweep.name)
def test_bound_holds_and_answers_past_it_are_valid(sweep: Sweep):
    # Only the easiest value, the bound and the hardest value are run.
    assert run_sweep(sweep.shortened(), (0, 1), fit_method).faults == ()
