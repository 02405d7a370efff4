"""Wilson's interval against its equation, published figures and its coverage."""

from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.apps.bench.shares import wilson_interval
from eyehand.errors import InputError

Z = 1.959963984540054


@pytest.mark.parametrize(
    ("wins", "tries", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),  # Newcombe 1998, table I
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_intervals_equal_published_ones(wins, tries, low, high):
    assert wilson_interval(wins, tries) == pytest.approx((low, high), abs=5e-5)


@given(st.integers(1, 1000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_both_ends_solve_the_equation_and_enclose_the_share(case):
    wins, tries = case
    share = wins / tries
    low, high = wilson_interval(wins, tries)
    assert 0 <= low <= share <= high <= 1
    for end in (low, high):
        assert (share - end) ** 2 == pytest.approx(Z**2 * end * (1 - end) / tries, abs=1e-12)


@given(st.integers(0, 50), st.integers(1, 50))
def test_interval_of_losses_mirrors_that_of_wins(wins, more):
    tries = wins + more
    low, high = wilson_interval(wins, tries)
    assert wilson_interval(more, tries) == pytest.approx((1 - high, 1 - low), abs=1e-12)


@pytest.mark.parametrize("share", [0.5, 0.8, 0.95])
def test_coverage_is_95_percent(share):
    tries = 60
    coverage = sum(
        comb(tries, wins) * share**wins * (1 - share) ** (tries - wins)
        for wins in range(tries + 1)
        if wilson_interval(wins, tries)[0] <= share <= wilson_interval(wins, tries)[1]
    )
    assert coverage == pytest.approx(0.95, abs=0.035)


def test_interval_without_tries_is_0_to_1():
    assert wilson_interval(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize("case", [(3, 2), (-1, 2)])
def test_rejects_invalid_counts(case):
    with pytest.raises(InputError):
        wilson_interval(*case)
