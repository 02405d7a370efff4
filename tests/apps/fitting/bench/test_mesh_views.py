"""Views of household meshes and scores of their fits, on meshes written by the tests."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.bench.evaluate_meshes import mesh_summary
from eyehand.apps.fitting.bench.household_meshes import HouseholdMesh, read_household
from eyehand.apps.fitting.bench.mesh_classes import class_of, half_of, plain_name
from eyehand.apps.fitting.bench.mesh_score import (
    fit_view,
    score_mesh_fit,
    score_parts,
    union_volume,
)
from eyehand.apps.fitting.bench.mesh_views import FACE_ON, PlacedMesh, mesh_views
from eyehand.apps.fitting.bench.resting_poses import hull_facets, resting_rotations
from eyehand.apps.mesh_file import join_meshes
from eyehand.errors import InputError
from eyehand.perception import Superquadric, SuperquadricFit
from eyehand.perception.superquadric import mesh

HALF = (0.03, 0.04, 0.06)


def box(half=HALF, place=(0.0, 0.0, 0.0), turn=None) -> Superquadric:
    """Return a box with nearly sharp edges."""
    pose = RigidTransform.from_components(np.array(place), turn or Rotation.identity())
    return Superquadric(np.array(half), (0.02, 0.02), pose, "box")


def household(solids) -> HouseholdMesh:
    """Return the mesh of solids that do not overlap."""
    vertices, faces = join_meshes([mesh(solid, 64) for solid in solids])
    return HouseholdMesh("test", "folder", "box", "settings", vertices, faces)


def write_obj(path, vertices, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines))


def test_names_have_a_class_and_a_half():
    assert plain_name("Shampoo_800_tex_visual") == "Shampoo"
    assert class_of("Shampoo") == "bottle"
    assert class_of("Shampoo", "tool") == "tool"
    assert class_of("unheard_of") == "other"
    assert half_of("power_drill") == half_of("035_power_drill") == "settings"
    assert {half_of(f"thing {k}") for k in range(20)} == {"settings", "report"}


def test_folders_are_read(tmp_path):
    write_obj(tmp_path / "cup_visual.obj", *mesh(box(), 8))
    write_obj(tmp_path / "cup_collision.obj", *mesh(box(), 8))
    (tmp_path / "classes.csv").write_text("name,class\ncup_visual,vessel\n")
    (found,) = read_household([tmp_path])
    assert (found.name, found.kind) == ("cup", "vessel")
    other = "report" if found.half == "settings" else "settings"
    assert read_household([tmp_path], other) == ()


def test_bad_folders_are_refused(tmp_path):
    with pytest.raises(InputError, match="no folder"):
        read_household([tmp_path / "missing"])
    with pytest.raises(InputError, match="no mesh"):
        read_household([tmp_path])
    vertices, faces = mesh(box(), 8)
    write_obj(tmp_path / "large.obj", 1000 * vertices, faces)
    with pytest.raises(InputError, match=r"at most 0\.6 m"):
        read_household([tmp_path])


def test_a_box_rests_on_its_three_sides():
    vertices = mesh(box(), 32)[0] @ Rotation.from_rotvec([0.1, 0.05, 0]).as_matrix().T
    rests = resting_rotations(vertices, 9)
    heights = [float(np.ptp(rest.apply(vertices)[:, 2])) for rest in rests]
    assert heights[0] == pytest.approx(0.12, abs=2e-3)
    assert {round(50 * height) for height in heights} == {3, 4, 6}


def test_facets_of_a_box_are_its_sides():
    normals, areas = hull_facets(mesh(box(), 64)[0])
    assert areas[:2] == pytest.approx([0.08 * 0.12] * 2, rel=0.1)
    assert np.abs(normals[0]) == pytest.approx([1, 0, 0], abs=0.05)


def test_occupancy_and_hull_of_a_hollow_shell():
    outer, inner = mesh(box(), 64), mesh(box((0.02, 0.03, 0.05)), 64)
    vertices, faces = join_meshes([outer, (inner[0], inner[1][:, ::-1])])
    shell = HouseholdMesh("shell", "f", "other", "settings", vertices, faces)
    material = np.count_nonzero(shell.in_material) * shell.sample_volume
    hull = np.count_nonzero(shell.in_hull) * shell.sample_volume
    assert hull == pytest.approx(8 * 0.03 * 0.04 * 0.06, rel=0.02)
    assert material == pytest.approx(hull - 8 * 0.02 * 0.03 * 0.05, rel=0.05)


def test_a_hole_in_the_scan_does_not_change_the_inside():
    vertices, faces = mesh(box(), 64)
    centres = vertices[faces].mean(axis=1)
    open_faces = faces[np.linalg.norm(centres - [0, 0, 0.06], axis=1) > 0.012]
    assert len(open_faces) < len(faces)
    mesh_with_hole = HouseholdMesh("open", "f", "box", "settings", vertices, open_faces)
    volume = np.count_nonzero(mesh_with_hole.in_material) * mesh_with_hole.sample_volume
    assert volume == pytest.approx(8 * 0.03 * 0.04 * 0.06, rel=0.03)


def test_the_true_solid_scores_perfectly_at_any_pose():
    pose = RigidTransform.from_components([0.3, -0.2, 0.1], Rotation.from_rotvec([0.3, 1, 2]))
    placed = PlacedMesh(household([box()]), pose)
    true = Superquadric(np.array(HALF), (0.02, 0.02), pose, "box")
    score = score_parts(placed, [true])
    assert score.iou > 0.98
    assert score.chamfer < 2e-4
    # The facets of the mesh cut the sharp corners.
    assert abs(score.width_error) < 1e-3
    assert score.usable


def test_errors_of_width_and_place_are_unusable():
    placed = PlacedMesh(household([box()]), RigidTransform.identity())
    wide = score_parts(placed, [box((0.036, 0.04, 0.06))])
    assert wide.width_error == pytest.approx(0.012, abs=1e-4)
    assert wide.clears
    assert not wide.usable
    assert wide.unsaid_unusable
    shifted = score_parts(placed, [box(place=(0.011, 0.0, 0.0))])
    assert abs(shifted.width_error) < 1e-4
    assert not shifted.clears
    assert score_parts(placed, [box(place=(0.009, 0.0, 0.0))]).usable


def test_parts_count_as_their_union():
    parts = [box((0.05, 0.01, 0.01)), box((0.01, 0.05, 0.01))]
    volume = 8e-6 * (2 * 5 - 1)
    assert union_volume(parts) == pytest.approx(volume, rel=0.02)
    arms = [box((0.01, 0.02, 0.01), (0.0, sign * 0.03, 0.0)) for sign in (-1, 1)]
    cross = household([parts[0], *arms])
    score = score_parts(PlacedMesh(cross, RigidTransform.identity()), parts)
    assert score.iou > 0.97
    assert score.hull_iou < 0.7


def test_a_refused_fit_is_never_usable_nor_unsaid():
    placed = PlacedMesh(household([box()]), RigidTransform.identity())
    score = score_mesh_fit(placed, SuperquadricFit.rejected("too few points"))
    assert score.refused
    assert not score.usable
    assert not score.unsaid_iou
    assert not score.unsaid_unusable
    assert score.iou == 0.0
    assert score.reason == "too few points"
    row = mesh_summary([("box", score)], "own")[0]
    assert row["refused_pct"] == 100.0
    assert row["width_error_median_mm"] is None


@pytest.mark.parametrize("noise", ["1mm", "realistic"])
def test_the_fit_of_a_view_finds_the_box(noise):
    item = household([box()])
    (view,) = mesh_views([item], (40.0,), noise=noise)
    fit, seconds = fit_view(view)
    score = score_mesh_fit(view.placed[0], fit, seconds)
    assert score.iou > 0.9
    assert score.usable
    assert score.side_sigmas.shape == (6,)
    assert seconds > 0


def test_views_are_reproducible_and_stand_on_the_table():
    item = household([box()])
    first, second = (mesh_views([item], (35.0, FACE_ON), poses=3, seed=4) for _ in range(2))
    assert len(first) == 6
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one.frame.depth, other.frame.depth)
        vertices = one.placed[0].pose.apply(item.vertices)
        assert vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
        assert np.count_nonzero(one.object_pixels) > 500


def test_a_face_on_view_looks_along_the_normal():
    (view,) = mesh_views([household([box()])], (FACE_ON,))
    pose = view.frame.T_world_camera
    assert pose is not None
    normal = view.placed[0].pose.rotation.as_matrix()[:, 0]
    cosine = abs(float(pose.rotation.as_matrix()[:, 2] @ normal))
    assert np.degrees(np.arccos(cosine)) < 6.0
