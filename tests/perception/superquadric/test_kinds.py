"""A kind is a promise about the numbers: solids that break it are refused by name."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.perception import FitOptions, Superquadric, fit_superquadric
from eyehand.perception.superquadric import PARAMETER_COUNT, Kind, canonical, sample_surface
from eyehand.perception.superquadric.kinds import basis, fixed_exponents, starting_axes
from eyehand.perception.superquadric.shape import KIND_TOLERANCE

POSE = RigidTransform.from_translation([0.1, 0.2, 0.3])
KINDS: tuple[Kind, ...] = get_args(Kind)


def solid(kind: Kind, axes, exponents) -> Superquadric:
    return Superquadric(np.array(axes, dtype=float), exponents, POSE, kind)


@pytest.mark.parametrize(
    ("kind", "axes", "exponents", "says"),
    [
        ("sphere", [0.04, 0.04, 0.05], (1.0, 1.0), "a sphere has equal semi-axes"),
        ("sphere", [0.04, 0.04, 0.04], (0.1, 1.0), "a sphere has equal semi-axes"),
        ("sphere", [0.04, 0.04, 0.04], (0.5, 0.5), "a sphere has equal semi-axes"),
        ("ellipsoid", [0.06, 0.05, 0.04], (1.0, 0.9), "an ellipsoid has exponents"),
        ("cylinder", [0.04, 0.05, 0.06], (0.1, 1.0), "a cylinder has a1 = a2"),
        ("cylinder", [0.04, 0.04, 0.06], (0.1, 0.5), "a cylinder has a1 = a2"),
        ("box", [0.06, 0.05, 0.04], (0.1, 0.2), "a box has equal exponents"),
    ],
)
def test_numbers_that_are_not_those_of_the_kind_are_refused(kind, axes, exponents, says):
    with pytest.raises(InputError, match=says):
        solid(kind, axes, exponents)
    assert solid("superquadric", axes, exponents).kind == "superquadric"
    assert solid("tapered", axes, exponents).kind == "tapered"


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_equal_means_equal_up_to_round_off(kind):
    exponents = (1.0, 1.0) if kind == "sphere" else (0.1, 1.0)
    assert solid(kind, [0.04, 0.04 * (1 + 0.5 * KIND_TOLERANCE), 0.04], exponents)
    with pytest.raises(InputError):
        solid(kind, [0.04, 0.04 * (1 + 3 * KIND_TOLERANCE), 0.04], exponents)


@given(
    kind=st.sampled_from(KINDS),
    axes=st.tuples(*[st.floats(0.002, 1.0)] * 3),
    free=st.tuples(*[st.floats(0.02, 1.98)] * 2),
)
def test_what_a_fit_makes_of_a_kind_is_of_that_kind(kind, axes, free):
    # As guesses do: through logarithms of the nearest semi-axes.
    near = np.exp(np.log(starting_axes(kind, np.array(axes))))
    made = solid(kind, near, fixed_exponents(kind) or free)
    assert canonical(made).kind == kind
    assert made.parameter_count == PARAMETER_COUNT[kind]
    # A step along the kind's own numbers stays of the kind.
    step = np.asarray(basis(kind)) @ np.linspace(-0.2, 0.3, PARAMETER_COUNT[kind])
    exponents = tuple(np.clip(np.array(made.exponents) + step[3:5], 0.02, 1.98).tolist())
    assert solid(kind, near * np.exp(step[:3]), exponents)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_that_is_asked_for_comes_back_as_itself(kind):
    body = solid("superquadric", [0.05, 0.045, 0.04], (0.6, 0.8))
    points = sample_surface(body, 200, np.random.default_rng(0))
    fit = fit_superquadric(points, options=FitOptions(kinds=(kind,)))
    assert fit.superquadric is not None
    assert fit.superquadric.kind == kind
