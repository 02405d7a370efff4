"""Tests of selecting fit options for a time budget, on a hand-written front."""

from dataclasses import replace

import pytest

from eyehand.errors import InputError
from eyehand.perception import FitOptions
from eyehand.perception.stored_front import StoredFront
from eyehand.perception.superquadric.options import FORMAT, STORED_FRONT, FrontPoint

BARE = {"points": 100, "optimiser": "lm", "kinds": ("superquadric",)}
FRONT = StoredFront(
    points=(
        FrontPoint("bare", BARE, 3.0, 80.0, 91.0, 1.0),
        FrontPoint("300 points, lm", {"points": 300, "optimiser": "lm"}, 6.0, 88.0, 95.0, 0.0),
        FrontPoint("default", {}, 18.0, 93.0, 97.0, 0.0),
    ),
    default_ms=18.0,
    data="written down by hand",
    seed=None,
    frames=1,
    machine="none",
)


@pytest.mark.parametrize(
    ("budget", "dials"),
    [(3.0, BARE), (5.99, BARE), (6.0, FRONT.points[1].dials), (18.0, {}), (1e6, {})],
)
def test_most_accurate_point_within_budget_is_selected(budget, dials):
    assert FitOptions.for_budget(budget, front=FRONT) == FitOptions(**dials)


def test_the_mean_over_real_objects_decides_if_it_is_known():
    points = (
        FrontPoint("one", {}, 3.0, 90.0, 95.0, 0.0, 80.0),
        FrontPoint("parts", {"max_parts": 5}, 6.0, 89.0, 95.0, 0.0, 90.0),
    )
    front = replace(FRONT, points=points)
    assert FitOptions.for_budget(10.0, front=front) == FitOptions(max_parts=5)
    with pytest.raises(InputError, match=r"mean IoU 80\.0 %"):
        FitOptions.for_budget(1.0, front=front)


def test_slower_machine_gets_faster_point():
    assert FitOptions.for_budget(6.0, slower=1.1, front=FRONT) == FitOptions(**BARE)
    assert FitOptions.for_budget(10.0, slower=0.5, front=FRONT) == FitOptions()


def test_budget_below_fastest_point_is_rejected():
    with pytest.raises(InputError, match=r"no fit is as fast as 1 ms: the fastest, bare, takes 3"):
        FitOptions.for_budget(1.0, front=FRONT)


@pytest.mark.parametrize("budget", [0.0, -1.0, float("nan"), float("inf")])
def test_invalid_budget_is_rejected(budget):
    with pytest.raises(InputError, match="budget"):
        FitOptions.for_budget(budget, front=FRONT)


def test_kinds_round_trip_through_file(tmp_path):
    path = tmp_path / "front.json"
    path.write_text(FORMAT.text(FRONT), encoding="utf-8")
    front = FORMAT.read(path)
    assert [point.fields for point in front.points] == [p.fields for p in FRONT.points]


def test_missing_front_file_error_suggests_command(tmp_path):
    with pytest.raises(InputError, match="make it with eyehand chart fit --store"):
        FORMAT.read(tmp_path / "front.json")


def test_stored_front_is_sorted_by_time_and_accuracy():
    points = FORMAT.read(STORED_FRONT).points
    times = [point.median_ms for point in points]
    assert times == sorted(times)
    assert [p.accuracy_pct for p in points] == sorted(p.accuracy_pct for p in points)
    assert FitOptions.for_budget(1e4) == FitOptions(**points[-1].fields)
    assert FitOptions.for_budget(times[0]) == FitOptions(**points[0].fields)
    with pytest.raises(InputError, match=points[0].name):
        FitOptions.for_budget(0.5 * times[0])
