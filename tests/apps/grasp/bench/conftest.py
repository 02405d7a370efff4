"""What tests of evaluations share."""

import os
import sys
from pathlib import Path

import pytest


@pytest.fixture
def made_up(monkeypatch):
    """Module of made-up trials that other processes find too."""
    here = str(Path(__file__).parent)
    monkeypatch.syspath_prepend(here)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([here, os.environ.get("PYTHONPATH", "")]))
    import made_up_trials

    yield made_up_trials
    sys.modules.pop("made_up_trials", None)
