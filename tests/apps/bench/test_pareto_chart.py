"""The Pareto chart: readable names for any points."""

from collections.abc import Sequence

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from eyehand.apps.bench.chart_style import Provenance
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


def legend_names(figure: Figure) -> list[str]:
    legend = figure.axes[0].get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def test_names_default_front_and_baselines():
    own = points(20, seed=4)
    baselines = [
        BaselineCurve("a baseline", tuple(points(3, seed=5))),
        BaselineCurve("poor", (own[0],)),
    ]
    figure = draw(own, 12, baselines)
    on_axes = [text.get_text() for text in figure.axes[0].texts]
    best = own[12]
    default = f"default: {best.accuracy_pct:.1f} % in {best.time_ms:.0f} ms"
    assert set(legend_names(figure)) == {default, "a baseline", "poor"}
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
    assert legend_names(figure) == ["default: 100.0 % in 5 ms"]


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
