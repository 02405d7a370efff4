"""The control options: range checks and their messages."""

import dataclasses

import pytest

from eyehand.control.options import _RANGES, ControlOptions
from eyehand.errors import InputError

NON_NUMERIC = ("safety",)
NUMERIC = [f.name for f in dataclasses.fields(ControlOptions) if f.name not in NON_NUMERIC]


def test_default_options_are_valid_and_frozen():
    options = ControlOptions()
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.dt = 0.1  # pyright: ignore[reportAttributeAccessIssue] # the invalid assignment under test


@pytest.mark.parametrize("name", NUMERIC)
@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0])
def test_options_reject_nan_infinite_and_negative_numbers(name, value):
    with pytest.raises(InputError, match=name):
        dataclasses.replace(ControlOptions(), **{name: value})


@pytest.mark.parametrize("name", NUMERIC)
@pytest.mark.parametrize("value", [None, "fast", (1.0,)])
def test_options_reject_values_that_are_no_numbers(name, value):
    with pytest.raises(InputError, match=name):
        dataclasses.replace(ControlOptions(), **{name: value})


@pytest.mark.parametrize("name", sorted(_RANGES))
def test_ranges_include_their_ends_and_appear_in_message(name):
    low, high = _RANGES[name]
    for end in (low, high):
        assert getattr(dataclasses.replace(ControlOptions(), **{name: end}), name) == end
    with pytest.raises(InputError, match=rf"{name} must lie in \[") as error:
        dataclasses.replace(ControlOptions(), **{name: 2.0 * high})
    assert f"{high:g}]" in str(error.value)


def test_options_reject_zero_period():
    with pytest.raises(InputError, match="dt must lie in"):
        ControlOptions(dt=0.0)


def test_message_for_unknown_weight_lists_choices():
    with pytest.raises(InputError, match="dynamic"):
        ControlOptions(beta="auto")  # pyright: ignore[reportArgumentType] # the invalid value under test


@pytest.mark.parametrize("beta", [0, 0.0, 0.5, 5.0, "dynamic"])
def test_weights_of_the_figure_are_valid(beta):
    assert ControlOptions(beta=beta).beta == beta
