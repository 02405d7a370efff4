"""Fixtures of the tests of evaluations."""

import os
import sys
from pathlib import Path

import pytest

from eyehand.apps.grasp.bench import jobs


@pytest.fixture
def made_up(monkeypatch):
    """Return the module of made-up trials, which other processes can import as well."""
    here = str(Path(__file__).parent)
    monkeypatch.syspath_prepend(here)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([here, os.environ.get("PYTHONPATH", "")]))
    # A made-up trial leaves no memory to return. Among the objects of all tests, a search for some
    # takes 0.1 s.
    monkeypatch.setattr(jobs, "return_freed_memory", lambda: None)
    import made_up_trials

    yield made_up_trials
    sys.modules.pop("made_up_trials", None)
