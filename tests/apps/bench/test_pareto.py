"""The Pareto front against its definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.apps.bench.pareto import pareto_front, simplest_front, thin_front
from eyehand.errors import InputError

# Few distinct values, so that ties occur.
POINTS = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=25)


def dominated(point, other):
    """Return whether `other` is at least as good in both and better in one."""
    return other[0] <= point[0] and other[1] >= point[1] and other != point


@given(POINTS)
def test_front_holds_undominated_points(points):
    front = pareto_front([p[0] for p in points], [p[1] for p in points])
    on_front = [points[index] for index in front]
    undominated = {p for p in points if not any(dominated(p, other) for other in points)}
    assert set(on_front) == undominated
    assert len(on_front) == len(undominated)  # equal points count once ...
    assert front == [points.index(p) for p in on_front]  # ... and it is the first


@given(POINTS)
def test_cost_and_gain_rise_along_the_front(points):
    costs, gains = [p[0] for p in points], [p[1] for p in points]
    front = pareto_front(costs, gains)
    assert (np.diff([costs[index] for index in front]) > 0).all()
    assert (np.diff([gains[index] for index in front]) > 0).all()


@given(POINTS, st.randoms())
def test_order_and_scale_do_not_matter(points, random):
    front = pareto_front([p[0] for p in points], [p[1] for p in points])
    shuffled = list(points)
    random.shuffle(shuffled)
    again = pareto_front([np.exp(p[0]) for p in shuffled], [3.0 * p[1] - 7.0 for p in shuffled])
    assert [points[index] for index in front] == [shuffled[index] for index in again]


@given(POINTS, st.floats(1.0, 3.0), st.integers(0, 3))
def test_simplest_front_costs_at_most_the_factor_more(points, factor, slack):
    costs, gains = [p[0] + 1.0 for p in points], [p[1] for p in points]
    front = simplest_front(costs, gains, factor, slack)
    assert (np.diff([costs[index] for index in front]) > 0).all()
    assert (np.diff([gains[index] for index in front]) > 0).all()
    for point in pareto_front(costs, gains):
        affordable = [k for k in front if costs[k] <= factor * costs[point]]
        # One slack for the dropped point, one for the dropped step.
        assert max(gains[k] for k in affordable) >= gains[point] - 2 * slack


@given(POINTS)
def test_simplest_front_without_slack_is_exact(points):
    costs, gains = [p[0] + 1.0 for p in points], [p[1] for p in points]
    assert simplest_front(costs, gains, 1.0) == pareto_front(costs, gains)


def test_simplest_front_prefers_simpler_of_equal_points():
    costs, gains = [40.0, 39.0, 20.0, 20.5], [97.0, 97.0, 90.0, 90.2]
    assert pareto_front(costs, gains) == [2, 3, 1]
    assert simplest_front(costs, gains, 1.05) == [2, 3, 0]
    assert simplest_front([22.0, 21.0], [98.7, 98.8], 1.05) == [1]
    assert simplest_front([22.0, 21.0], [98.7, 98.8], 1.05, same_gain=0.15) == [0]
    with pytest.raises(InputError, match="difference"):
        simplest_front(costs, gains, 1.1, same_gain=-0.1)
    with pytest.raises(InputError, match="factor"):
        simplest_front(costs, gains, 0.9)
    with pytest.raises(InputError, match="> 0"):
        simplest_front([0.0], [1.0], 1.1)


def test_front_of_known_points():
    costs, gains = [10, 5, 20, 12, 5], [90, 80, 95, 85, 70]
    assert pareto_front(costs, gains) == [1, 0, 2]
    assert pareto_front([], []) == []


def test_thin_front_drops_small_steps():
    gains = [80.0, 80.2, 80.9, 81.0, 83.0]
    assert thin_front(gains, [0, 1, 2, 3, 4], 0.5) == [0, 2, 4]
    assert thin_front(gains, [0, 1, 2, 3, 4], 0.0) == [0, 1, 2, 3, 4]
    assert thin_front(gains, [], 0.5) == []


def test_rejects_invalid_points():
    with pytest.raises(InputError, match="same length"):
        pareto_front([1.0], [1.0, 2.0])
    with pytest.raises(InputError, match="finite"):
        pareto_front([1.0], [float("nan")])
