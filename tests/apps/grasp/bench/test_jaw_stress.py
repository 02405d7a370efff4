"""`eyehand stress grasp --hand panda`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from eyehand.apps.bench.stress import StressArguments
from eyehand.apps.grasp.bench.jaw_stress import jaw_sweeps
from eyehand.apps.grasp.bench.stress import stress_grasp
from eyehand.apps.grasp.clutter_round import ClutterTrial, run_clutter_round
from eyehand.errors import InputError
from eyehand.grasping import JawOptions

SHARED = Path(__file__).resolve().parents[5] / "shared" / "data" / "objects"


def test_hand_needs_objects():
    with pytest.raises(InputError, match="--hand needs --objects"):
        stress_grasp(hand="panda")


def test_folder_is_checked(tmp_path):
    with pytest.raises(InputError, match=str(tmp_path)):
        stress_grasp(StressArguments(), hand="panda", objects=tmp_path)


def test_sweep_runs_one_grasp():
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    sweeps = {sweep.name: sweep for sweep in jaw_sweeps("panda", str(SHARED / "packed"))}
    assert {"calibration", "noise", "friction", "mass", "camera", "density"} <= set(sweeps)
    trial = sweeps["density"].attempt(3.0, 11, JawOptions())
    assert trial.refused or trial.seconds is not None


def test_heavy_objects_are_not_lifted():
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    trial = {"family": "packed", "seed": 11, "objects": str(SHARED / "packed"), "max_attempts": 1}
    light = run_clutter_round(trial)
    heavy = run_clutter_round({**trial, "changes": {"mass_factor": 100.0}})
    assert light["removed"] == 1
    assert heavy["removed"] == 0
    assert heavy["heavy"]
    assert np.isfinite(heavy["attempts"][0]["predicted"])
    assert ClutterTrial(family="packed", seed=0, objects="").changes.mass_factor == 1.0
