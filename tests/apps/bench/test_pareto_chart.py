"""The Pareto chart: readable names for any points."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from eyehand.apps.bench.chart_labels import PointLabel, label_points
from eyehand.apps.bench.chart_style import Provenance, new_chart, set_percent_axis, set_time_axis
from eyehand.apps.bench.pareto import pareto_front
from eyehand.apps.bench.pareto_chart import BaselineCurve, ChartPoint, ParetoChart


def draw(own: list[ChartPoint], default: int, baselines: Sequence[BaselineCurve] = ()) -> Figure:
    """Draw the chart of some settings."""
    front = pareto_front([p.time_ms for p in own], [p.accuracy_pct for p in own])
    chart = ParetoChart("Title", "subtitle", own, front, "overlap F", MADE, default, baselines)
    return chart.figure()


MADE = Provenance("made-up figures", 1, 1)


def points(count: int, seed: int) -> list[ChartPoint]:
    """Return settings whose accuracy roughly grows with time."""
    rng = np.random.default_rng(seed)
    times = np.geomspace(3, 80, count) * rng.uniform(0.9, 1.1, count)
    return [
        ChartPoint(f"setting {k}", float(t), float(98 - 30 / t**0.7 - rng.uniform(0, 3)))
        for k, t in enumerate(times)
    ]


@settings(max_examples=6)
@given(st.integers(1, 8), st.integers(0, 10**6))
def test_names_do_not_overlap_or_leave_axes(count, seed):
    _, (axes,) = new_chart("Title", "subtitle")
    set_time_axis(axes, 1, 1000)
    set_percent_axis(axes, 50, 99, stretched=True)
    rng = np.random.default_rng(seed)
    names = [
        PointLabel(float(np.exp(rng.uniform(1, 6))), float(rng.uniform(60, 98)), f"method {k}")
        for k in range(count)
    ]
    boxes = label_points(axes, names, [[(name.x, name.y)] for name in names])
    left, bottom, right, top = axes.bbox.extents
    for index, box in enumerate(boxes):
        assert left <= box[0] < box[2] <= right
        assert bottom <= box[1] < box[3] <= top
        for other in boxes[:index]:
            apart = (
                box[2] <= other[0] or other[2] <= box[0] or box[3] <= other[1] or other[3] <= box[1]
            )
            assert apart


def test_name_is_drawn_in_returned_box():
    _, (axes,) = new_chart("Title", "subtitle")
    set_time_axis(axes, 1, 1000)
    set_percent_axis(axes, 0, 100)
    (box,) = label_points(axes, [PointLabel(30.0, 50.0, "a name", "right")], [])
    (text,) = axes.texts
    drawn = text.get_window_extent()
    assert [drawn.x0, drawn.y0, drawn.x1, drawn.y1] == pytest.approx(box, abs=2.5)


@pytest.mark.parametrize("top", [106, 115])
def test_leader_line_crosses_no_name_and_no_point_if_possible(top):
    figure, (axes,) = new_chart("Title", "subtitle")
    set_time_axis(axes, 8, 292)
    set_percent_axis(axes, 15, top)
    default, near = (19.1, 96.5), (18.8, 99.5)
    names = [
        PointLabel(*default, "default: 96.5 %, never touched", "right", bold=True),
        PointLabel(*near, "default + planner: 99.5 %, never touched\nplanning 15 ms", "right"),
    ]
    spans = [[(19.1, 93.0), (19.1, 98.3)], [(18.8, 97.2), (18.8, 99.9)]]
    first, _ = label_points(axes, names, [[default], [near], *spans])
    figure.canvas.draw()
    line = next(text for text in axes.texts if isinstance(text, Annotation) and "+" in str(text))
    assert line.arrow_patch is not None
    path = line.arrow_patch.get_path()
    along = line.arrow_patch.get_transform().transform(path.interpolated(50).vertices)
    inside = (along > first[:2]).all(axis=1) & (along < first[2:]).all(axis=1)
    assert not inside.any()
    if top > 110:
        assert np.linalg.norm(along - axes.transData.transform(default), axis=1).min() > 10


def test_names_default_front_and_baselines():
    own = points(20, seed=4)
    baselines = [
        BaselineCurve("a baseline", tuple(points(3, seed=5))),
        BaselineCurve("poor", (own[0],)),
    ]
    figure = draw(own, 12, baselines)
    axes = figure.axes[0]
    on_axes = [text.get_text() for text in axes.texts]
    best = own[12]
    assert f"default: {best.accuracy_pct:.1f} % in {best.time_ms:.0f} ms" in on_axes
    assert {"a baseline", "poor"} <= set(on_axes)
    key = [text.get_text() for text in figure.texts]
    numbers = [text for text in key if text.isdigit()]
    assert numbers == [str(k) for k in range(1, len(numbers) + 1)]
    assert 3 <= len(numbers) <= 8
    assert set(numbers) <= set(on_axes)


@pytest.mark.parametrize("seed", range(3))
def test_numbers_do_not_overlap(seed):
    own = points(60, seed)
    default = own[35]
    axes = draw(own, 35).axes[0]
    names = [text for text in axes.texts if isinstance(text, Annotation)]
    numbered = [name.xy for name in names if name.get_text().isdigit()]
    places = axes.transData.transform([*numbered, (default.time_ms, default.accuracy_pct)])
    gaps = np.linalg.norm(places[:, None] - places, axis=2)
    # The circles are 11.5 points across, 32 px.
    assert gaps[~np.eye(len(places), dtype=bool)].min() > 32


def test_draws_single_point():
    (point,) = points(1, seed=0)
    figure = draw([point], 0)
    assert "overlap F" in figure.axes[0].get_ylabel()


def test_draws_points_at_0_and_100_percent():
    own = [ChartPoint("perfect", 5.0, 100.0), ChartPoint("none", 4.0, 0.0)]
    draw(own, 0)
    draw(own[1:], 0)


def test_label_states_true_accuracy():
    figure = draw([ChartPoint("default", 5.0, 100.0)], 0)
    labels = [text.get_text() for text in figure.axes[0].texts]
    assert "default: 100.0 % in 5 ms" in labels


def ticks(figure: Figure) -> dict[str, float]:
    """Return the labels of the accuracy axis and their positions."""
    axes = figure.axes[0]
    words = [label.get_text() for label in axes.get_yticklabels()]
    return dict(zip(words, axes.get_yticks(), strict=True))


def test_perfect_points_lie_on_100_percent_level():
    own = [ChartPoint("plain", 5, 100.0), ChartPoint("poor", 9, 50.0)]
    figure = ParetoChart("Title", "subtitle", own, [0], "picks", MADE, max_shown_pct=75.0).figure()
    found = ticks(figure)
    assert found["100 %"] == 75.0
    assert max(found.values()) == 75.0, "no label above the level"
    assert "70 %" in found or "60 %" in found


def test_level_of_imperfect_points_is_not_labelled_100_percent():
    found = ticks(draw([ChartPoint("plain", 5, 99.95), ChartPoint("poor", 9, 97.0)], 0))
    assert found["\N{GREATER-THAN OR EQUAL TO} 99.9 %"] == 99.9
    assert "100 %" not in ticks(draw([ChartPoint("plain", 5, 99.0)], 0))


def test_names_all_of_few_settings():
    own = [ChartPoint("plain", 5, 90.0), ChartPoint("same", 5, 90.0), ChartPoint("late", 9, 80.0)]
    figure = draw(own, 0)
    key = " ".join(text.get_text() for text in figure.texts)
    assert "same: 90.0 %" in key
    assert "late: 80.0 %" in key
    texts = [text for text in figure.axes[0].texts if isinstance(text, Annotation)]
    numbers = {text.get_text(): text for text in texts}
    assert {"1", "2"} <= set(numbers)
    assert numbers["1"].xyann[0] > 0, "beside the default, which covers it"
