"""The experiment `slip`: gradient, area under the curve, and bad recordings."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import check_grad

from eyehand.apps.touch.slip_network import HIDDEN, network_loss
from eyehand.apps.touch.slip_recordings import (
    CLASSES,
    ELECTRODES,
    SETS,
    TOUCH,
    fourier_features,
    slip_auc,
)


def write_recordings(folder: Path) -> Path:
    """Write recordings whose mean depends on the class, of one object per set."""
    rng = np.random.default_rng(0)
    for label, name in enumerate(CLASSES):
        (folder / name).mkdir(parents=True)
        for objects in SETS.values():
            table = rng.normal(0, 1, (60, ELECTRODES)) + 10 * np.eye(ELECTRODES)[label]
            np.savetxt(folder / name / f"{objects[0]}{label}.csv", table, delimiter=",", header="e")
    return folder


def test_separable_recordings_are_classified(tmp_path, run_experiment):
    data = write_recordings(tmp_path / "csvs")
    code, out, _ = run_experiment("slip", "--data", data, "--json", "--out", tmp_path / "out")
    assert code == 0
    rows = {row["name"]: row for row in json.loads(out)["rows"]}
    assert rows["mean"]["small_right_pct"] > 99.0
    assert rows["mean"]["small_auc"] > 0.99
    # Only the offset depends on the class here. The Fourier features leave it out.
    assert rows["Fourier (chapter)"]["small_right_pct"] < 40.0
    assert (tmp_path / "out" / "slip.png").stat().st_size > 10_000


def test_gradient_equals_differences():
    rng = np.random.default_rng(0)
    values, labels = rng.normal(size=(30, 4)), rng.integers(0, 7, 30)
    weights = 0.3 * rng.normal(size=4 * HIDDEN + HIDDEN + 7 * HIDDEN + 7)
    error = check_grad(
        lambda w: network_loss(w, values, labels)[0],
        lambda w: network_loss(w, values, labels)[1],
        weights,
    )
    assert error < 1e-5


def test_area_counts_ordered_pairs():
    rng = np.random.default_rng(1)
    scores, labels = rng.normal(size=(40, 7)), rng.integers(0, 7, 40)
    labels[:3] = TOUCH
    odds = np.exp(scores)[:, TOUCH] / np.exp(scores).sum(axis=1)
    slips, rests = odds[labels != TOUCH], odds[labels == TOUCH]
    assert slip_auc(scores, labels) == pytest.approx((slips[:, None] < rests).mean())


def test_fourier_features_do_not_depend_on_the_offset():
    readings = np.random.default_rng(2).normal(size=(4, 5, ELECTRODES))
    assert fourier_features(readings + 100.0) == pytest.approx(fourier_features(readings))


def test_missing_recordings_exit_with_code_2(tmp_path, run_experiment):
    code, _, err = run_experiment("slip", "--data", tmp_path)
    assert code == 2
    assert "one folder of recordings per class (n, e, s, w, cw, aw, t)" in err
