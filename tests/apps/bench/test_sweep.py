"""Sweeps: break point, bound, exceptions of the method, chart."""

import numpy as np
import pytest

from eyehand.apps.bench import sweep_chart as sweep_chart
from eyehand.apps.bench.stress import OtherMethod, StressStage, run_methods
from eyehand.apps.bench.sweep import (
    Sweep,
    SweepResult,
    SweepStep,
    Trial,
    format_value,
    run_sweep,
)
from eyehand.apps.bench.sweep_chart import point_rows, sweep_rows, write_stress_chart
from eyehand.apps.segmentation.stress import segmentation_stage
from eyehand.apps.segmentation.stress_trial import SegmentCallable
from eyehand.errors import InputError
from eyehand.perception import DepthFrame, Segmentation


def find_nothing(frame: DepthFrame) -> Segmentation:
    """Find no object."""
    return Segmentation(np.zeros(frame.depth.shape, np.int32), None, 0.001, {})


def sweep(attempt, *, values=(0, 1, 2, 3), holds_to: float | None = 1, repeats=None) -> Sweep:
    return Sweep("made-up", "difficulty", "mm", values, holds_to, attempt, "right", repeats)


def passes_below(limit: float):
    def attempt(value: float, seed: int, method: SegmentCallable) -> Trial:
        return Trial(value < limit, "" if value < limit else "wrong", score=0.5, seconds=0.1)

    return attempt


def test_sweep_breaks_at_first_value_with_too_few_passes():
    def attempt(value: float, seed: int, method: SegmentCallable) -> Trial:
        # At 2, one of ten fails, the maximum. At 3, two of ten fail.
        return Trial(seed >= {2: 1, 3: 2}.get(int(value), 0))

    result = run_sweep(sweep(attempt, holds_to=2), range(10), find_nothing)
    assert [step.pass_rate for step in result.steps] == [1.0, 1.0, 0.9, 0.8]
    assert result.breaks_at == 3
    assert result.faults == ()


def test_fault_names_value_and_mistake():
    result = run_sweep(sweep(passes_below(1)), [0, 1], find_nothing)
    assert result.breaks_at == 1
    (fault,) = result.faults
    assert fault == "made-up at 1 mm: 0 of 2 right; wrong"


def test_answers_past_bound_may_be_wrong_but_not_unclean():
    def attempt(value: float, seed: int, method: SegmentCallable) -> Trial:
        return Trial(value < 2, clean=value < 3, note="NaN" if value == 3 else "")

    result = run_sweep(sweep(attempt), [0], find_nothing)
    assert result.breaks_at == 2
    assert result.faults == ("made-up at 3 mm: 0 of 1 right; NaN",)


def test_exception_is_unclean_trial():
    def attempt(value: float, seed: int, method: SegmentCallable) -> Trial:
        if value == 2:
            raise ZeroDivisionError("division\nby zero")
        return Trial(True)

    result = run_sweep(sweep(attempt), [0], find_nothing)
    assert len(result.steps) == 4
    assert result.steps[2].worst == Trial(
        False, "raised ZeroDivisionError: division by zero", clean=False
    )
    assert len(result.faults) == 1


def test_attempts_get_method_and_every_seed():
    calls = []

    def attempt(value: float, seed: int, method: SegmentCallable) -> Trial:
        assert method is find_nothing
        calls.append((value, seed))
        return Trial(True)

    run_sweep(sweep(attempt, values=(0, 1)), [4, 5], find_nothing)
    assert calls == [(0, 4), (0, 5), (1, 4), (1, 5)]
    calls.clear()
    run_sweep(sweep(attempt, values=(0, 1), repeats=1), [4, 5], find_nothing)
    assert calls == [(0, 4), (1, 4)]


def test_shortened_sweep_keeps_both_ends_and_bound():
    assert sweep(passes_below(2)).shortened().values == (0, 1, 3)
    assert sweep(passes_below(2), holds_to=3).shortened().values == (0, 3)


def test_answers_without_bound_may_be_wrong_but_not_unclean():
    free = sweep(passes_below(0), holds_to=None)
    assert run_sweep(free, [0], find_nothing).faults == ()
    assert free.shortened().values == (0, 3)

    def crash(value: float, seed: int, method: SegmentCallable) -> Trial:
        raise ValueError("difficulty")

    assert len(run_sweep(sweep(crash, holds_to=None), [0], find_nothing).faults) == 4


def test_worst_trial_is_unclean_then_wrong():
    right, wrong, unclean = Trial(True), Trial(False), Trial(False, clean=False)
    assert SweepStep(0, (right, wrong, unclean)).worst is unclean
    assert SweepStep(0, (right, wrong)).worst is wrong
    assert SweepStep(0, (right,)).scores == ()
    assert SweepStep(0, (right,)).median_seconds is None


@pytest.mark.parametrize(
    "bad",
    [{"values": (1,)}, {"values": (1, 1, 2)}, {"holds_to": 7}],
)
def test_rejects_sweeps_with_invalid_values_or_bound(bad):
    with pytest.raises(InputError, match="made-up"):
        sweep(passes_below(2), **bad)


def test_rejects_sweep_without_seeds():
    with pytest.raises(InputError, match="seed"):
        run_sweep(sweep(passes_below(2)), [], find_nothing)


def test_formats_values_with_unit():
    assert format_value(5, "mm") == "5 mm"
    assert format_value(0.5, "") == "0.5"
    assert format_value(15, "°") == "15°"
    assert format_value(307200, "px") == "307200 px"


def results() -> list[SweepResult]:
    return [
        run_sweep(sweep(passes_below(limit)), [0, 1], find_nothing) for limit in (1, 2, 3, 4, 5, 0)
    ]


def test_rows_hold_break_points_and_shares():
    rows = sweep_rows(results())
    assert [row["breaks_at"] for row in rows] == [1, 2, 3, None, None, 0]
    assert [row["bound_kept"] for row in rows] == [False, True, True, True, True, False]
    points = point_rows(results(), segmentation_stage().report)
    assert len(points) == 24
    assert points[2] == {
        "name": "made-up",
        "value": 2,
        "unit": "mm",
        "must_hold": False,
        "trials": 2,
        "right_pct": 0.0,
        "overlap_f_pct": 50.0,
        "segment_ms": 100.0,
        "wrong": "wrong",
    }


def test_other_methods_are_columns_and_have_bounds_of_their_own():
    def attempt(value: float, seed: int, limit: float) -> Trial:
        return Trial(value < limit, "" if value < limit else "wrong")

    stage = StressStage(
        "made-up",
        [],
        3.0,
        segmentation_stage().report,
        1,
        1,
        method_name="strong",
        others=[OtherMethod("weak", 1.0, {"made-up": 1}), OtherMethod("free", 0.0, {})],
    )
    result = run_methods(stage, sweep(attempt, holds_to=2), [0, 1], quick=False)
    (row,) = sweep_rows([result])
    assert (row["breaks_at"], row["breaks_at_weak"], row["breaks_at_free"]) == (3, 1, 0)
    assert (row["holds_to"], row["holds_to_weak"], row["holds_to_free"]) == (2, 1, None)
    assert result.faults == ("made-up, weak, at 1 mm: 0 of 2 right; wrong",)
    points = point_rows([result], stage.report)
    assert [point["method"] for point in points] == 4 * ["strong"] + 4 * ["weak"] + 4 * ["free"]
    quick = run_methods(stage, sweep(attempt, holds_to=2), [0], quick=True)
    assert quick.sweep.values == (0, 1, 2, 3)


def test_writes_chart_and_table(tmp_path):
    path = tmp_path / "stress.png"
    write_stress_chart(path, results(), segmentation_stage().report, seeds=2, first_seed=0)
    assert path.stat().st_size > 10_000
    lines = path.with_suffix(".csv").read_text().splitlines()
    assert lines[0].startswith("name,value,unit,must_hold,trials,right_pct")
    assert len(lines) == 25


@pytest.mark.parametrize("count", [1, 2, 5])
def test_texts_of_chart_do_not_overlap(tmp_path, monkeypatch, count):
    drawn = []
    monkeypatch.setattr(sweep_chart, "write_chart", lambda figure, *_: drawn.append(figure))
    one = results()[0]
    write_stress_chart(tmp_path / "a.png", [one] * count, segmentation_stage().report, 2, 0)
    (figure,) = drawn
    figure.canvas.draw()
    words = [*figure.texts]
    for panel in figure.axes:
        if panel.axison:
            words += [panel.title, panel._left_title, panel.xaxis.label]
    boxes = [text.get_window_extent() for text in words if text.get_text()]
    assert len(boxes) == 3 + 2 * count
    for number, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:number]), words[number]
