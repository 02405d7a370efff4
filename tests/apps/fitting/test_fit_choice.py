"""Conversion of command-line choices to fit options."""

from typing import get_args

import pytest

from eyehand.apps.fit import FitChoice
from eyehand.errors import InputError
from eyehand.perception import FitOptions
from eyehand.perception.superquadric import Kind, OptimiserName


def test_no_choice_gives_default_options():
    assert FitChoice().options() == FitOptions()


@pytest.mark.parametrize("kind", get_args(Kind))
def test_kind_limits_the_tried_kinds(kind):
    assert FitChoice(kind=kind).options().kinds == (kind,)


@pytest.mark.parametrize("optimiser", get_args(OptimiserName))
def test_points_optimiser_and_noise_are_passed_on(optimiser):
    options = FitChoice(points=123, optimiser=optimiser, noise_mm=3.0).options()
    assert (options.points, options.optimiser, options.noise) == (123, optimiser, 0.003)


def test_budget_selects_a_stored_setting(monkeypatch):
    monkeypatch.setattr(FitOptions, "for_budget", lambda ms: FitOptions(points=int(20 * ms)))
    options = FitChoice(budget_ms=10.0, kind="box", noise_mm=2.0).options()
    assert options == FitOptions(points=200, kinds=("box",), noise=0.002)


def test_max_parts_is_passed_on():
    assert FitChoice(max_parts=4).options() == FitOptions(max_parts=4)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"noise_mm": 0.0}, "--noise-mm"),
        ({"noise_mm": float("nan")}, "--noise-mm"),
        ({"budget_ms": 0.0}, "--budget-ms"),
        ({"budget_ms": float("inf")}, "--budget-ms"),
        ({"max_parts": 0}, "--max-parts"),
        ({"max_parts": 1000}, "--max-parts"),
        ({"budget_ms": 10.0, "points": 500}, "--points"),
        ({"budget_ms": 10.0, "optimiser": "lm"}, "--optimiser"),
    ],
)
def test_invalid_choices_are_rejected_by_name(values, message):
    with pytest.raises(InputError, match=message):
        FitChoice(**values)


def test_impossible_choices_are_rejected():
    with pytest.raises(InputError, match="points"):
        FitChoice(points=3).options()
    with pytest.raises(InputError):
        FitChoice(budget_ms=1e-6).options()
