"""Fixtures of the tests of evaluations."""

import os
import sys
from pathlib import Path

import pytest


@pytest.fixture
def made_up(monkeypatch):
    """Return the module of made-up trials, which other processes can import as well."""
    here = str(Path(__file__).parent)
    monkeypatch.syspath_prepend(here)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([here, os.environ.get("PYTHONPATH", "")]))
    import made_up_trials

    yield made_up_trials
    sys.modules.pop("made_up_trials", None)
