"""The fit follows its cloud: a moved, scaled or rewritten cloud gives the moved, scaled solid."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import mesh, sample_surface

FOLLOWS = 1e-5
"""Largest distance of the two surfaces, as a share of the solid's largest semi-axis."""
LENGTHS = ("noise", "silhouette_margin", "plane_scale")
"""Options that are lengths, m; so is the range of semi-axes."""
DIRECTIONS = np.random.default_rng(0).normal(size=(500, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)

CAMERA = np.array([0.35, -0.3, 0.5])
STRAIGHT = (0.0, 0.0)
SOLIDS: dict[str, tuple[list[float], tuple[float, float], tuple[float, float]]] = {
    "ball": ([0.04, 0.04, 0.04], (1.0, 1.0), STRAIGHT),
    "can": ([0.035, 0.035, 0.06], (0.1, 1.0), STRAIGHT),
    "egg": ([0.07, 0.05, 0.035], (1.0, 1.0), STRAIGHT),
    "brick": ([0.03, 0.05, 0.08], (0.1, 0.1), STRAIGHT),
    "pillow": ([0.06, 0.045, 0.025], (0.5, 0.6), STRAIGHT),
    "diamond": ([0.05, 0.05, 0.04], (1.0, 1.7), STRAIGHT),
    "cup": ([0.04, 0.04, 0.05], (0.1, 1.0), (0.25, 0.25)),
}
SEEN = ("view", "table", "whole")
"""One view, one view of what stands on a known plane, the whole surface."""
CLOUDS = [(name, seen) for name in SOLIDS for seen in SEEN if name != "cup" or seen == "whole"]


def look(name: str, seen: str, count: int = 700, noise: float = 0.001) -> dict[str, Any]:
    """The arguments of a fit: one view's points with camera and plane, as far as they are known."""
    rng = np.random.default_rng([len(name), len(seen)])
    axes, exponents, taper = SOLIDS[name]
    pose = RigidTransform.from_rotation(Rotation.from_euler("z", 0.4))
    kind = "tapered" if any(taper) else "superquadric"
    solid = Superquadric(np.array(axes), exponents, pose, kind, taper)
    points = sample_surface(solid, 4 * count, rng)
    if seen != "whole":
        points = points[np.einsum("ij,ij->i", CAMERA - points, solid.normals(points)) > 0]
    points = points[:count] + noise * rng.normal(size=(min(count, len(points)), 3))
    given_too = {"view": ("view_origin",), "table": ("view_origin", "support_plane")}
    known = {"view_origin": CAMERA, "support_plane": np.array([0.0, 0.0, 1.0, axes[2]])}
    return {"points": points} | {key: known[key] for key in given_too.get(seen, ())}


@cache
def fitted(name: str, seen: str) -> SuperquadricFit:
    """The fit that others must follow."""
    return fit_superquadric(**look(name, seen))


def moved(cloud: dict[str, Any], T: RigidTransform) -> dict[str, Any]:
    """The same look in another frame."""
    there = {key: T.apply(cloud[key]) for key in ("points", "view_origin") if key in cloud}
    if "support_plane" in cloud:
        normal = T.rotation.apply(cloud["support_plane"][:3])
        there["support_plane"] = np.append(
            normal, cloud["support_plane"][3] - normal @ T.translation
        )
    return there


def scaled(cloud: dict[str, Any], factor: float) -> dict[str, Any]:
    """The same look with all lengths times a factor."""
    there = {key: factor * cloud[key] for key in ("points", "view_origin") if key in cloud}
    if "support_plane" in cloud:
        there["support_plane"] = cloud["support_plane"] * [1.0, 1.0, 1.0, factor]
    return there


def apart(first: Superquadric, second: Superquadric) -> float:
    """Distance of two surfaces, as a share of the first's largest semi-axis.

    For convex solids the largest difference of their supports is the Hausdorff distance; points
    of one surface measured from the other see the hollows as well.
    """
    # About the first's centre, so that far from the origin no digits are lost here.
    between = DIRECTIONS @ (second.centre - first.centre)
    supports = [solid.support(DIRECTIONS) - DIRECTIONS @ solid.centre for solid in (first, second)]
    points = first.project_radially(mesh(first, 16)[0])
    distances = [np.abs(supports[1] - supports[0] + between), np.abs(second.distance(points))]
    return float(np.concatenate(distances).max() / first.semi_axes.max())


def at(T: RigidTransform, solid: Superquadric) -> Superquadric:
    """The solid in another frame."""
    return replace(solid, pose=T * solid.pose)


def solid_of(fit: SuperquadricFit) -> Superquadric:
    assert fit, fit.reason
    assert fit.superquadric is not None
    return fit.superquadric


def check(here: SuperquadricFit, there: SuperquadricFit, expected: Superquadric) -> None:
    """`there` is the solid expected of one that moved with its cloud, of the same kind."""
    found = solid_of(there)
    assert found.kind == solid_of(here).kind
    assert apart(expected, found) < FOLLOWS


TURNS = st.one_of(
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1),
    # Quarter and half turns swap axes and flip signs.
    st.sampled_from([tuple(Rotation.as_quat(turn)) for turn in Rotation.create_group("O")]),
)
PLACES = st.tuples(*[st.floats(-10, 10)] * 3)


@pytest.mark.parametrize(("name", "seen"), CLOUDS)
@given(turn=TURNS)
@settings(max_examples=3, deadline=None)
def test_a_turned_cloud_gives_the_turned_solid(name, seen, turn):
    cloud, T = look(name, seen), RigidTransform.from_rotation(Rotation.from_quat(turn))
    here, there = fitted(name, seen), fit_superquadric(**moved(cloud, T))
    check(here, there, at(T, solid_of(here)))


@pytest.mark.parametrize(("name", "seen"), CLOUDS)
@given(place=PLACES)
@example(place=(-6e3, 7e3, 4e3))
@settings(max_examples=2, deadline=None)
def test_a_shifted_cloud_gives_the_shifted_solid_also_ten_kilometres_away(name, seen, place):
    cloud, T = look(name, seen), RigidTransform.from_translation(place)
    here, there = fitted(name, seen), fit_superquadric(**moved(cloud, T))
    check(here, there, at(T, solid_of(here)))


@given(cloud=st.sampled_from(CLOUDS), turn=TURNS, place=PLACES)
@settings(max_examples=25, deadline=None)
def test_a_moved_cloud_gives_the_moved_solid(cloud, turn, place):
    seen = look(*cloud)
    T = RigidTransform.from_components(place, Rotation.from_quat(turn))
    here, there = fitted(*cloud), fit_superquadric(**moved(seen, T))
    check(here, there, at(T, solid_of(here)))


@pytest.mark.parametrize(("name", "seen"), CLOUDS)
@given(factor=st.floats(0.1, 10.0))
@settings(max_examples=3, deadline=None)
def test_a_scaled_cloud_gives_the_scaled_solid(name, seen, factor):
    cloud, options = look(name, seen), FitOptions()
    low, high = options.axis_range
    lengths = {key: factor * getattr(options, key) for key in LENGTHS}
    larger = replace(options, axis_range=(factor * low, factor * high), **lengths)
    here = fitted(name, seen)
    there = fit_superquadric(**scaled(cloud, factor), options=larger)
    solid = solid_of(here)
    pose = RigidTransform.from_components(factor * solid.centre, solid.pose.rotation)
    check(here, there, replace(solid, semi_axes=factor * solid.semi_axes, pose=pose))


@pytest.mark.parametrize(("name", "seen"), CLOUDS)
def test_single_precision_is_read_as_the_numbers_it_holds(name, seen):
    cloud = {key: value.astype(np.float32) for key, value in look(name, seen).items()}
    cloud.pop("support_plane", None)
    wide = {key: value.astype(np.float64) for key, value in cloud.items()}
    here, there = fit_superquadric(**cloud), fit_superquadric(**wide)
    assert np.array_equal(solid_of(here).pose.as_matrix(), solid_of(there).pose.as_matrix())
    assert np.array_equal(solid_of(here).semi_axes, solid_of(there).semi_axes)


@pytest.mark.parametrize(("name", "seen"), CLOUDS)
def test_rounding_to_single_precision_moves_the_solid_no_farther_than_the_points(name, seen):
    cloud = look(name, seen)
    rounded = cloud | {"points": cloud["points"].astype(np.float32)}
    here, there = fitted(name, seen), fit_superquadric(**rounded)
    check(here, there, solid_of(here))


@pytest.mark.parametrize(("name", "seen"), CLOUDS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=2, deadline=None)
def test_the_order_of_the_points_does_not_matter(name, seen, seed):
    cloud = look(name, seen)
    order = np.random.default_rng(seed).permutation(len(cloud["points"]))
    here = fitted(name, seen)
    there = fit_superquadric(**(cloud | {"points": cloud["points"][order]}))
    check(here, there, solid_of(here))


@pytest.mark.parametrize(("name", "seen"), CLOUDS)
def test_the_same_cloud_twice_gives_the_same_bits(name, seen):
    first, again = solid_of(fitted(name, seen)), solid_of(fit_superquadric(**look(name, seen)))
    assert np.array_equal(first.pose.as_matrix(), again.pose.as_matrix())
    assert np.array_equal(first.semi_axes, again.semi_axes)
    assert first.exponents == again.exponents
