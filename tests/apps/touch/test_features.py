"""The experiment `features`, and its synthetic imprints."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.touch.imprints import imprints
from eyehand.errors import InputError
from eyehand.tactile import TactileArray

PAD = TactileArray.flat()


def test_moments_and_weighted_centre_are_most_accurate_and_files_are_written(
    tmp_path, run_experiment
):
    code, out, _ = run_experiment("features", "--quick", "--json", "--out", tmp_path)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_features/1"
    rows = {row["name"]: row for row in report["rows"]}
    hough = [row for name, row in rows.items() if name.startswith("hough")]
    assert all(rows["moments"]["error_p50_deg"] < row["error_p50_deg"] / 3 for row in hough)
    assert all(rows["moments"]["time_p50_us"] < row["time_p50_us"] / 3 for row in hough)
    weighted, binarised = rows["centre weighted 0 %"], rows["centre binarised 0 %"]
    assert weighted["error_rms_mm"] < 0.2 * binarised["error_rms_mm"]
    full, linear = rows["calibration full curve"], rows["calibration linear range"]
    assert full["error_rms_mm"] < 0.6 * linear["error_rms_mm"]
    assert (tmp_path / "features.png").stat().st_size > 20_000
    with (tmp_path / "features.csv").open() as file:
        assert len(list(csv.DictReader(file))) == len(rows)


@pytest.mark.parametrize("kind", ["short line", "crossing line", "probe"])
def test_imprints_are_repeatable_and_match_their_ground_truth(kind):
    first, again = (list(imprints(PAD, kind, 3, 5)) for _ in range(2))
    (shifted,) = imprints(PAD, kind, 1, 6)
    for one, other in zip(first, again, strict=True):
        assert np.array_equal(one.image.pressures, other.image.pressures)
    assert np.array_equal(shifted.image.pressures, first[1].image.pressures)
    for each in first:
        peak = PAD.positions[np.argmax(each.image.pressures), :2]
        across = [-np.sin(each.angle), np.cos(each.angle)]
        off = peak - each.centre if kind == "probe" else (peak - each.centre) @ across
        assert np.linalg.norm(off) < 0.004


def test_imprints_rejects_curved_pad():
    with pytest.raises(InputError, match="flat"):
        next(imprints(TactileArray.curved(), "probe", 1, 0))
