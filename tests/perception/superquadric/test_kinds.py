"""Tests of the kinds of solids and of the constraints on their parameters."""

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
    ("kind", "axes", "exponents", "message"),
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
def test_parameters_inconsistent_with_kind_are_rejected(kind, axes, exponents, message):
    with pytest.raises(InputError, match=message):
        solid(kind, axes, exponents)
    assert solid("superquadric", axes, exponents).kind == "superquadric"
    assert solid("tapered", axes, exponents).kind == "tapered"


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_axes_are_compared_up_to_rounding(kind):
    exponents = (1.0, 1.0) if kind == "sphere" else (0.1, 1.0)
    assert solid(kind, [0.04, 0.04 * (1 + 0.5 * KIND_TOLERANCE), 0.04], exponents)
    with pytest.raises(InputError):
        solid(kind, [0.04, 0.04 * (1 + 3 * KIND_TOLERANCE), 0.04], exponents)


@given(
    kind=st.sampled_from(KINDS),
    axes=st.tuples(*[st.floats(0.002, 1.0)] * 3),
    free=st.tuples(*[st.floats(0.02, 1.98)] * 2),
)
def test_starts_and_steps_keep_kind(kind, axes, free):
    # Starts store the logarithms of the semi-axes.
    start_axes = np.exp(np.log(starting_axes(kind, np.array(axes))))
    start = solid(kind, start_axes, fixed_exponents(kind) or free)
    assert canonical(start).kind == kind
    assert start.parameter_count == PARAMETER_COUNT[kind]
    # A step along the free parameters keeps the kind.
    step = np.asarray(basis(kind)) @ np.linspace(-0.2, 0.3, PARAMETER_COUNT[kind])
    exponents = tuple(np.clip(np.array(start.exponents) + step[3:5], 0.02, 1.98).tolist())
    assert solid(kind, start_axes * np.exp(step[:3]), exponents)


@pytest.mark.parametrize("kind", KINDS)
def test_requested_kind_is_returned(kind):
    superquadric = solid("superquadric", [0.05, 0.045, 0.04], (0.6, 0.8))
    points = sample_surface(superquadric, 200, np.random.default_rng(0))
    fit = fit_superquadric(points, options=FitOptions(kinds=(kind,)))
    assert fit.superquadric is not None
    assert fit.superquadric.kind == kind
