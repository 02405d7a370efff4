"""Tests of vessels: geometry, mesh, and fits to cups seen in one view."""

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.bench.clouds import fit_case
from eyehand.errors import InputError
from eyehand.perception import (
    CameraIntrinsics,
    DepthFrame,
    Superquadric,
    SuperquadricFit,
    SupportPlane,
    fit_region,
    fit_superquadric,
)
from eyehand.perception.superquadric import Rim, Vessel, vessel_mesh
from eyehand.perception.superquadric.opening import find_opening

NOISE = 0.001
TABLE = np.array([0.0, 0.0, 1.0, 0.0])
WALL = 0.004
RADIUS, HEIGHT = 0.04, 0.09
RAYS = 70


def camera(elevation_deg: float) -> NDArray[np.float64]:
    """Return a camera position 0.6 m from a cup on the table."""
    angle = np.radians(elevation_deg)
    return np.array([0.0, -0.6 * np.cos(angle), 0.6 * np.sin(angle) + HEIGHT / 2])


def cup_cloud(
    elevation_deg: float,
    *,
    hollow: bool = True,
    lower_radius: float = RADIUS,
    wall: float = WALL,
    seed: int = 0,
) -> NDArray[np.float64]:
    """Return points (N, 3) of an upright cup, or of a can, at the pixels of a camera.

    The rays are sampled where they first meet the material.
    """
    eye = camera(elevation_deg)
    forward = np.array([0.0, 0.0, HEIGHT / 2]) - eye
    forward /= np.linalg.norm(forward)
    side = np.array([1.0, 0.0, 0.0])
    reach = np.linspace(-0.13, 0.13, RAYS)
    across, up = np.meshgrid(reach, reach)
    rays = forward + across[..., None] * side + up[..., None] * np.cross(side, forward)
    rays = rays.reshape(-1, 3) / np.linalg.norm(rays.reshape(-1, 3), axis=1, keepdims=True)
    depths = np.arange(0.45, 0.75, 0.0005)
    first = np.full(len(rays), np.nan)
    for depth in depths[::-1]:
        x, y, z = (eye + depth * rays).T
        outside = lower_radius + (RADIUS - lower_radius) * z / HEIGHT
        radius = np.hypot(x, y)
        material = (radius <= outside) & (z >= 0) & (z <= HEIGHT)
        if hollow:
            material &= (radius >= outside - wall) | (z <= wall)
        first[material] = depth
    seen = np.isfinite(first)
    noise = np.random.default_rng(seed).normal(0.0, NOISE, len(rays))
    return (eye + (first + noise)[:, None] * rays)[seen]


@cache
def cup_fit(elevation_deg: float, lower_radius: float = RADIUS) -> SuperquadricFit:
    points = cup_cloud(elevation_deg, lower_radius=lower_radius)
    return fit_superquadric(points, view_origin=camera(elevation_deg), support_plane=TABLE)


def cylinder_vessel(
    wall: float | None = WALL, turn: float = 0.0, *, through: bool = False
) -> Vessel:
    """Return a cylindrical cup of RADIUS and HEIGHT with its foot at the origin, then turned."""
    pose = RigidTransform.from_rotation(Rotation.from_rotvec([turn, 0.0, 0.0]))
    place = pose * RigidTransform.from_translation([0.0, 0.0, HEIGHT / 2])
    outer = Superquadric(np.array([RADIUS, RADIUS, HEIGHT / 2]), (0.02, 1.0), place, "cylinder")
    axes = pose.rotation.as_matrix()
    middle = RADIUS - (wall or 0.0) / 2
    rim = Rim(HEIGHT * axes[:, 2], np.array([middle, middle]), axes[:, :2].T)
    return Vessel(outer, rim, wall, through)


@pytest.mark.parametrize("elevation_deg", [25.0, 40.0, 60.0, 80.0])
def test_cup_is_a_vessel(elevation_deg):
    fit = cup_fit(elevation_deg)
    assert fit
    assert fit.superquadric is not None
    assert isinstance(fit.solid, Vessel)
    assert fit.superquadric is fit.solid.outer
    assert fit.parts == (fit.superquadric,)
    assert fit.superquadric.kind == "cylinder"
    assert fit.superquadric.semi_axes[0] == pytest.approx(RADIUS, abs=0.0015)
    rim = fit.solid.rim
    assert rim.centre == pytest.approx([0.0, 0.0, HEIGHT], abs=0.0025)
    assert rim.semi_axes == pytest.approx(RADIUS - WALL / 2, abs=0.0025)
    assert fit.solid.opening[2] > 0.99
    assert fit.spread < 2.0 * NOISE
    assert fit.solid.wall == pytest.approx(WALL, abs=0.0015)


def test_tumbler_is_a_tapered_vessel():
    fit = cup_fit(40.0, 0.028)
    assert isinstance(fit.solid, Vessel)
    assert fit.superquadric is not None
    assert fit.superquadric.kind == "tapered"
    side = np.array([1.0, 0.0, 0.0])
    assert fit.solid.support(side) == pytest.approx(RADIUS, abs=0.003)


@pytest.mark.parametrize("elevation_deg", [25.0, 45.0, 80.0])
def test_can_is_no_vessel(elevation_deg):
    points = cup_cloud(elevation_deg, hollow=False)
    fit = fit_superquadric(points, view_origin=camera(elevation_deg), support_plane=TABLE)
    assert fit.vessel is None
    assert fit.solid is fit.superquadric


@pytest.mark.parametrize("group", ["view-1mm", "mismatched", "compound"])
@pytest.mark.parametrize("seed", range(20))
def test_closed_solids_have_no_opening(group, seed):
    case = fit_case(group, seed, 1500)
    assert case.view_origin is not None
    towards = case.view_origin - case.points.mean(axis=0)
    towards /= np.linalg.norm(towards)
    directions = [towards, *np.eye(3), *-np.eye(3)]
    assert find_opening(case.points, case.view_origin, directions, 0.0015) is None


def test_vessel_follows_rigid_motion():
    motion = RigidTransform.from_components([0.3, -0.2, 1.0], Rotation.from_rotvec([2.0, 0.4, 0.1]))
    points, eye = cup_cloud(40.0), camera(40.0)
    normal = motion.rotation.apply(TABLE[:3])
    plane = np.append(normal, -normal @ motion.translation)
    moved = fit_superquadric(
        motion.apply(points), view_origin=motion.apply(eye), support_plane=plane
    )
    vessel = cup_fit(40.0).vessel
    assert vessel is not None
    assert moved.vessel is not None
    assert moved.vessel.rim.centre == pytest.approx(motion.apply(vessel.rim.centre), abs=0.001)
    assert moved.vessel.opening == pytest.approx(motion.rotation.apply(vessel.opening), abs=0.03)


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_wall_floor_and_cavity(turn):
    vessel = cylinder_vessel(turn=turn)
    rotation = Rotation.from_rotvec([turn, 0.0, 0.0])
    middle = [RADIUS - WALL / 2, 0.0, 0.05]
    points = rotation.apply(
        [middle, [0, 0, WALL / 2], [0, 0, 0.05], [0, 0, HEIGHT + 0.01], [0.06, 0, 0.05]]
    )
    assert vessel.contains(points).tolist() == [True, True, False, False, False]
    near = rotation.apply([[RADIUS + 0.001, 0, 0.05], [RADIUS - WALL - 0.001, 0, 0.05]])
    assert vessel.distance(near) == pytest.approx(0.001, abs=1e-4)
    at_rim = rotation.apply([[0, RADIUS - WALL + g, HEIGHT - 0.001] for g in (-0.001, 0.001)])
    assert (vessel.cavity_distance(at_rim) < 0.0).tolist() == [True, False]
    assert vessel.opening == pytest.approx(rotation.apply([0.0, 0.0, 1.0]))


def test_mesh_is_closed_and_has_the_volume_of_the_wall():
    vessel = cylinder_vessel()
    vertices, faces = vessel_mesh(vessel, 64)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert np.all(counts == 2)
    inner = RADIUS - WALL
    expected = np.pi * (RADIUS**2 * HEIGHT - inner**2 * (HEIGHT - WALL))
    assert vessel.volume == pytest.approx(expected, rel=0.05)
    assert np.abs(vessel.distance(vertices)).max() < 0.0015
    assert vertices[:, 2].max() == pytest.approx(HEIGHT, abs=1e-4)


def test_ring_has_no_floor():
    ring = cylinder_vessel(through=True)
    points = [[0, 0, WALL / 2], [RADIUS - WALL / 2, 0, WALL / 2], [0, 0, -0.01]]
    assert ring.contains(points).tolist() == [False, True, False]
    inner = RADIUS - WALL
    near_foot = [[inner - 0.001, 0, 0.002], [inner + 0.001, 0, 0.002]]
    assert (ring.cavity_distance(near_foot) < 0.0).tolist() == [True, False]
    vertices, faces = vessel_mesh(ring, 64)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert np.all(counts == 2)
    assert ring.volume == pytest.approx(np.pi * (RADIUS**2 - inner**2) * HEIGHT, rel=0.05)
    assert np.linalg.norm(vertices[:, :2], axis=1).min() > inner - 0.001


def rendered_cup(wall: float, height: float, floor: float, elevation_deg: float) -> SuperquadricFit:
    """Fit a cup or ring of RADIUS in a depth image, with the table behind it."""
    eye = camera(elevation_deg)
    view = np.array([0.0, 0.0, height / 2]) - eye
    view /= np.linalg.norm(view)
    across = np.array([1.0, 0.0, 0.0])
    axes = RigidTransform.from_components(
        eye, Rotation.from_matrix(np.column_stack([across, np.cross(view, across), view]))
    )
    intrinsics = CameraIntrinsics(420.0, 420.0, 79.5, 79.5, 160, 160)
    rays = intrinsics.rays().reshape(-1, 3) @ axes.rotation.as_matrix().T
    first = -eye[2] / rays[:, 2]
    labels = np.zeros(len(rays), dtype=np.int32)
    for depth in np.arange(0.7, 0.5, -0.001):
        x, y, z = (eye + depth * rays).T
        radius = np.hypot(x, y)
        material = (radius <= RADIUS) & (z >= 0.001) & (z <= height)
        material &= (radius >= RADIUS - wall) | (z <= floor)
        first[material], labels[material] = depth, 1
    noisy = first + np.random.default_rng(1).normal(0.0, NOISE, len(rays))
    shape = (intrinsics.height, intrinsics.width)
    frame = DepthFrame(noisy.reshape(shape).astype(np.float32), intrinsics, axes)
    table = SupportPlane(TABLE[:3], 0.0).moved(axes.inv())
    return fit_region(frame, labels.reshape(shape), 1, table)[0]


@pytest.mark.parametrize("elevation_deg", [40.0, 55.0, 70.0])
def test_ring_is_said_to_be_one(elevation_deg):
    fit = rendered_cup(0.012, 0.03, 0.0, elevation_deg)
    assert fit
    assert fit.superquadric is not None
    assert fit.vessel is not None
    assert fit.vessel.through
    assert fit.superquadric.semi_axes[0] == pytest.approx(RADIUS, abs=0.002)
    assert fit.covered_share < 0.03


@pytest.mark.parametrize("share", [0.1, 0.3, 0.4, 0.45, 0.5])
def test_cup_of_any_wall_is_a_vessel(share):
    fit = rendered_cup(share * RADIUS, 0.07, 0.006, 45.0)
    assert fit
    assert fit.superquadric is not None
    assert fit.vessel is not None
    assert not fit.vessel.through
    assert fit.superquadric.semi_axes[0] == pytest.approx(RADIUS, abs=0.002)


def test_rim_points_lie_on_the_ellipse():
    rim = Rim(np.ones(3), np.array([0.05, 0.03]), np.eye(3)[:2])
    points = rim.points(16)
    assert rim.scale(points) == pytest.approx(1.0)
    assert points[:, 2] == pytest.approx(1.0)
    assert points[0] == pytest.approx([1.05, 1.0, 1.0])
    assert rim.opening == pytest.approx([0.0, 0.0, 1.0])


def test_bad_values_are_refused():
    with pytest.raises(InputError, match="wall of a vessel"):
        cylinder_vessel(-0.001)
    with pytest.raises(InputError, match="mesh resolution"):
        vessel_mesh(cylinder_vessel(), 4)


def test_unknown_wall_is_drawn():
    vessel = cylinder_vessel(None)
    assert vessel.wall is None
    assert vessel.drawn_wall > 0.0
    assert 0.0 < vessel.volume < vessel.outer.volume


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_normals_point_out_of_the_material(turn):
    vessel = cylinder_vessel(turn=turn)
    rotation = Rotation.from_rotvec([turn, 0.0, 0.0])
    inner = RADIUS - WALL
    points = [[RADIUS, 0, 0.05], [inner, 0, 0.05], [0, inner + 0.001, HEIGHT], [0, 0, WALL]]
    outwards = [[1, 0, 0], [-1, 0, 0], [0, 0, 1], [0, 0, 1]]
    assert vessel.normals(rotation.apply(points)) == pytest.approx(
        rotation.apply(outwards), abs=0.02
    )


def test_cup_with_a_thick_wall_is_a_vessel():
    wall = 0.3 * RADIUS
    points = cup_cloud(50.0, wall=wall)
    fit = fit_superquadric(points, view_origin=camera(50.0), support_plane=TABLE)
    assert fit.vessel is not None
    assert fit.vessel.wall == pytest.approx(wall, abs=0.003)
    assert fit.vessel.outer.semi_axes[0] == pytest.approx(RADIUS, abs=0.003)
