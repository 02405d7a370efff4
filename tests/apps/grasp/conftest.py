"""A demo that clears a table with one object, shared by the tests of its record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from eyehand.apps.grasp.bench.trial import GraspTrial, trial_cell
from eyehand.apps.grasp.demo_record import DemoRecord
from eyehand.apps.grasp.demo_run import run_demo
from eyehand.apps.grasp.demo_scene import DemoScene, demo_scene
from eyehand.grasping.clearing import ClearOptions

SEED = 1


@dataclass
class CountingObserver:
    """An observer that counts its calls."""

    cycles: int = 0
    before: int = 0
    after: int = 0

    def on_cycle(self, cycle) -> None:
        """Count a control cycle."""
        assert np.isfinite(cycle.force).all()
        self.cycles += 1

    def on_pick(self, choice, report) -> None:
        """Count a pick, before and after."""
        self.before += report is None
        self.after += report is not None


@pytest.fixture(scope="session")
def single() -> DemoScene:
    return demo_scene("single", SEED, 1)


@pytest.fixture(scope="session")
def cleared(single) -> tuple[DemoRecord, CountingObserver]:
    observer = CountingObserver()
    trial = GraspTrial(family="single", seed=SEED, objects=1)
    built = trial_cell(single.objects, trial)
    record = run_demo(single.source, trial, built, [lambda *_: observer], ClearOptions(picks=2))
    return record, observer
