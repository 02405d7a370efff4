"""The chart of the features as a person runs it, and the imprints it is measured on."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.touch.imprints import imprints
from eyehand.errors import InputError
from eyehand.tactile import TactileArray

PAD = TactileArray.flat()


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main(["experiment", "features", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


def test_moments_and_weights_win_and_the_files_are_written(tmp_path, capsys):
    code, out, _ = run("--quick", "--json", "--out", tmp_path, capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.experiment_features/1"
    rows = {row["name"]: row for row in report["rows"]}
    hough = [row for name, row in rows.items() if name.startswith("hough")]
    assert all(rows["moments"]["error_p50_deg"] < row["error_p50_deg"] / 3 for row in hough)
    assert all(rows["moments"]["time_p50_us"] < row["time_p50_us"] / 3 for row in hough)
    weighted, alike = rows["centre weighted 0 %"], rows["centre binarised 0 %"]
    assert weighted["error_rms_mm"] < 0.2 * alike["error_rms_mm"]
    full, linear = rows["calibration full curve"], rows["calibration linear range"]
    assert full["error_rms_mm"] < 0.6 * linear["error_rms_mm"]
    assert (tmp_path / "features.png").stat().st_size > 20_000
    with (tmp_path / "features.csv").open() as file:
        assert len(list(csv.DictReader(file))) == len(rows)


@pytest.mark.parametrize("wrong", [("--imprints", 1), ("--seed", -1)])
def test_impossible_wishes_are_refused_in_one_line(wrong, capsys):
    code, _, err = run(*wrong, capsys=capsys)
    assert code == 2
    assert wrong[0] in err


@pytest.mark.parametrize("kind", ["short line", "crossing line", "probe"])
def test_imprints_follow_from_their_seed_and_lie_where_they_say(kind):
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


def test_imprints_are_refused_on_curved_pads():
    with pytest.raises(InputError, match="flat"):
        next(imprints(TactileArray.curved(), "probe", 1, 0))
