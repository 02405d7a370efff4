"""Tests of selecting options for a time budget, on a hand-written front."""

from dataclasses import replace

import pytest

from eyehand.errors import InputError
from eyehand.perception.segmentation import SegmentationOptions
from eyehand.perception.segmentation.options import (
    FRONT_FORMAT,
    STORED_FRONT,
    FrontPoint,
    select_point,
)
from eyehand.perception.stored_front import StoredFront

FRONT = StoredFront(
    points=(
        FrontPoint("stride 4", {"stride": 4, "threads": 1}, 4.0, 60.0, 75.0),
        FrontPoint("stride 2", {"stride": 2, "threads": 1}, 10.0, 80.0, 90.0),
        FrontPoint("2 threads", {"stride": 1, "threads": 2}, 25.0, 93.0, 97.0),
        FrontPoint("default", {"stride": 1, "threads": 1}, 40.0, 93.5, 97.0),
    ),
    default_ms=40.0,
    data="written down by hand",
    seed=None,
    frames=1,
    machine="none",
)


@pytest.mark.parametrize(
    ("budget", "stride", "threads"),
    [(4.0, 4, 1), (9.99, 4, 1), (10.0, 2, 1), (30.0, 1, 2), (40.0, 1, 1), (1e6, 1, 1)],
)
def test_most_accurate_point_within_budget_is_selected(budget, stride, threads):
    point = select_point(budget, front=FRONT)
    assert point.dials == {"stride": stride, "threads": threads}


def test_slower_machine_gets_faster_point():
    assert select_point(10.0, slower=1.01, front=FRONT).dials["stride"] == 4
    assert select_point(8.0, slower=0.8, front=FRONT).dials["stride"] == 2


def test_thread_limit_is_respected():
    assert select_point(30.0, threads=1, front=FRONT).dials["stride"] == 2


def test_budget_below_fastest_point_is_rejected():
    with pytest.raises(InputError, match=r"as fast as 3 ms: the fastest, stride 4, takes 4 ms"):
        select_point(3.0, front=FRONT)
    with pytest.raises(InputError, match=r"takes 12 ms, 3 times the stored 4 ms"):
        select_point(10.0, slower=3.0, front=FRONT)


@pytest.mark.parametrize("budget", [0.0, -1.0, float("nan"), float("inf")])
def test_invalid_budget_is_rejected(budget):
    with pytest.raises(InputError, match="budget"):
        select_point(budget, front=FRONT)


def test_invalid_machine_is_rejected():
    with pytest.raises(InputError, match="slower"):
        select_point(10.0, slower=0.0, front=FRONT)
    with pytest.raises(InputError, match="threads"):
        select_point(10.0, threads=0, front=FRONT)


def test_front_round_trips_through_file(tmp_path):
    path = tmp_path / "front.json"
    path.write_text(FRONT_FORMAT.text(FRONT))
    assert FRONT_FORMAT.read(path) == FRONT


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema": "other/1"}'])
def test_invalid_front_file_is_rejected(tmp_path, text):
    path = tmp_path / "front.json"
    path.write_text(text)
    with pytest.raises(InputError, match="--store"):
        FRONT_FORMAT.read(path)


def test_stored_front_is_sorted_by_time_and_accuracy():
    front = FRONT_FORMAT.read(STORED_FRONT)
    times = [point.median_ms for point in front.points]
    shares = [point.worst_kinds_pct for point in front.points]
    assert times == sorted(times)
    assert shares == sorted(shares)
    assert SegmentationOptions.for_budget(1e4) == replace(
        SegmentationOptions(), **front.points[-1].dials
    )
    fastest = front.points[0]
    assert SegmentationOptions.for_budget(fastest.median_ms) == replace(
        SegmentationOptions(), **fastest.dials
    )
    with pytest.raises(InputError, match=fastest.name):
        SegmentationOptions.for_budget(0.5 * fastest.median_ms)
