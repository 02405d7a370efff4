"""Options of the control basis: what is out of range is refused by name."""

import dataclasses

import pytest

from eyehand.control.options import _RANGES, ControlOptions
from eyehand.errors import InputError

NO_NUMBERS = ("safety",)
NUMBERS = [f.name for f in dataclasses.fields(ControlOptions) if f.name not in NO_NUMBERS]


def test_the_defaults_are_valid_and_frozen():
    options = ControlOptions()
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.dt = 0.1  # pyright: ignore[reportAttributeAccessIssue] # that is the point


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0])
def test_no_number_may_be_nan_infinite_or_negative(name, value):
    with pytest.raises(InputError, match=name):
        dataclasses.replace(ControlOptions(), **{name: value})


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [None, "fast", (1.0,)])
def test_what_is_no_number_is_refused(name, value):
    with pytest.raises(InputError, match=name):
        dataclasses.replace(ControlOptions(), **{name: value})


@pytest.mark.parametrize("name", sorted(_RANGES))
def test_ranges_hold_their_ends_and_the_message_names_them(name):
    low, high = _RANGES[name]
    for end in (low, high):
        assert getattr(dataclasses.replace(ControlOptions(), **{name: end}), name) == end
    with pytest.raises(InputError, match=rf"{name} must lie in \[") as told:
        dataclasses.replace(ControlOptions(), **{name: 2.0 * high})
    assert f"{high:g}]" in str(told.value)


def test_a_period_of_zero_is_refused():
    with pytest.raises(InputError, match="dt must lie in"):
        ControlOptions(dt=0.0)


def test_unknown_weights_name_the_choices():
    with pytest.raises(InputError, match="dynamic"):
        ControlOptions(beta="auto")  # pyright: ignore[reportArgumentType] # a user's typing error


@pytest.mark.parametrize("beta", [0, 0.0, 0.5, 5.0, "dynamic"])
def test_all_weights_of_the_figure_are_valid(beta):
    assert ControlOptions(beta=beta).beta == beta
