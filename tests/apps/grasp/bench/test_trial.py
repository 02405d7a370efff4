"""Complete trials in the simulated cell, and the scenes and scores of trials."""

import itertools
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

from eyehand.apps.grasp import true_solids
from eyehand.apps.grasp.bench.stress_objects import object_on_table
from eyehand.apps.grasp.bench.trial import GraspTrial, Scorer, run_trial, trial_cell
from eyehand.apps.grasp.mesh_scenes import ObjectSource, check_mesh_scenes, mesh_scene
from eyehand.apps.grasp.scenes import grasp_scene
from eyehand.data_synth.cell import GraspCell
from eyehand.errors import InputError

if TYPE_CHECKING:
    from eyehand.grasping.cell import CycleInfo
    from eyehand.grasping.pick_state import SelectedGrasp
    from eyehand.grasping.report import PickReport


def write_box(path, half):
    """Write a closed box as an OBJ file."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [f"f {a + 1} {b + 1} {c + 1}\nf {a + 1} {c + 1} {d + 1}" for a, b, c, d in quads]
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in corners] + faces
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("known", [False, True])
def test_single_object_is_put_into_tray(known):
    result = run_trial(GraspTrial(family="single", seed=8, known=known))
    assert result.placed == result.total == 1
    assert result.stopped == "clear"
    (pick,) = [row for row in result.picks if row.success]
    assert pick.outcome == "placed"
    assert pick.object == "box_1"
    assert pick.touched_before == 0
    assert pick.pads >= 2
    assert pick.rows <= 6
    assert pick.seconds < 12
    assert pick.displacement is not None
    assert 0.0 <= pick.displacement < 0.03


def test_mesh_from_folder_is_picked(tmp_path):
    write_box(tmp_path / "carton.obj", (0.02, 0.025, 0.035))
    trial = GraspTrial(family="packed", seed=1, objects=1, objects_dir=str(tmp_path), known=True)
    result = run_trial(trial)
    assert result.placed == 1
    assert result.picks[0].object == "carton_1"
    assert result.picks[0].kind == "box"


def test_packed_meshes_are_apart_and_pile_starts_in_air(tmp_path):
    write_box(tmp_path / "a.obj", (0.02, 0.025, 0.035))
    write_box(tmp_path / "b.obj", (0.03, 0.03, 0.03))
    items = mesh_scene(ObjectSource(str(tmp_path)), "packed", 3, 5)
    assert len({item.name for item in items}) == 5
    for one in items:
        assert (one.pose.apply(one.vertices)[:, 2] >= 0).all()
        for other in items:
            if other is not one:
                assert np.linalg.norm(one.centre[:2] - other.centre[:2]) > 0.05
    pile = mesh_scene(ObjectSource(str(tmp_path)), "pile", 3, 4)
    heights = [item.pose.apply(item.vertices)[:, 2] for item in pile]
    for below, above in itertools.pairwise(heights):
        assert above.min() > below.max()


def test_too_many_meshes_are_refused_with_possible_number(tmp_path):
    write_box(tmp_path / "crate.obj", (0.10, 0.10, 0.1))
    with pytest.raises(InputError, match=r"9 objects do not fit .* request at most [1-8] objects"):
        mesh_scene(ObjectSource(str(tmp_path)), "packed", 0, 9)
    with pytest.raises(InputError, match="packed scene, seed 5: 9 objects do not fit"):
        check_mesh_scenes(ObjectSource(str(tmp_path)), [("single", 5), ("packed", 5)], 9)
    check_mesh_scenes(ObjectSource(str(tmp_path)), [("single", 5), ("packed", 5)], 1)


def test_pile_too_wide_for_table_is_refused(tmp_path):
    write_box(tmp_path / "panel.obj", (0.29, 0.29, 0.02))
    with pytest.raises(InputError, match="too wide for the table beside the tray"):
        mesh_scene(ObjectSource(str(tmp_path)), "pile", 0, 2)


def test_large_meshes_are_clear_of_tray(tmp_path):
    for number, half in enumerate([(0.05, 0.06, 0.07), (0.07, 0.06, 0.08), (0.08, 0.05, 0.05)]):
        write_box(tmp_path / f"carton{number}.obj", half)
    cell = GraspCell()
    for seed in range(40):
        for item in mesh_scene(ObjectSource(str(tmp_path)), "packed", seed, 5):
            cell.check_clear(item.name, item.centre, item.radius)


def test_pile_is_on_table_and_clear_of_tray():
    cell = GraspCell()
    for item in grasp_scene("pile", 5175).objects:
        cell.check_clear(item.name, item.shape.centre, 0.05)
        assert (np.abs(item.shape.centre[:2]) < 0.25).all()


@pytest.mark.parametrize("family", ["single", "packed", "pile"])
def test_scene_is_determined_by_seed(family):
    first, again = grasp_scene(family, 4), grasp_scene(family, 4)
    for one, other in zip(first.objects, again.objects, strict=True):
        np.testing.assert_array_equal(one.shape.centre, other.shape.centre)
    assert len(first.objects) == (1 if family == "single" else 5)


def test_unknown_family_is_refused():
    with pytest.raises(InputError, match="single, packed, pile"):
        grasp_scene("heap", 0)  # pyright: ignore[reportArgumentType] - the wrong name is the test


def test_scorer_finds_object_beside_close_wall():
    wall_size, box_size = (0.05, 0.09, 0.09), (0.045, 0.045, 0.09)
    wall = object_on_table("box", wall_size, 0, name="wall", offset=(0.0675, 0.0))
    cell, robot = trial_cell([object_on_table("box", box_size, 0), wall], GraspTrial(known=True))
    scorer = Scorer(cell, robot)
    for name in ("box", "wall"):
        middle = robot.object_pose(name).translation
        # The segment may show another object. The grasp decides.
        target = SimpleNamespace(points=robot.object_pose("box").translation[None])
        plan = SimpleNamespace(geometry=SimpleNamespace(centre=middle))
        scorer.on_pick(cast("SelectedGrasp", SimpleNamespace(target=target, plan=plan)), None)
        assert scorer._target == name


def test_scorer_uses_vertices_without_fitted_solid(tmp_path, monkeypatch):
    write_box(tmp_path / "thing.obj", (0.02, 0.025, 0.035))
    items = mesh_scene(ObjectSource(str(tmp_path)), "packed", 1, 2)
    none = SimpleNamespace(superquadric=None, reason="no solid")
    monkeypatch.setattr(true_solids, "fit_superquadric", lambda points, options: none)
    _, robot = trial_cell(items, GraspTrial())
    for item in items:
        assert (
            true_solids.nearest_object(robot, robot.object_pose(item.name).translation) == item.name
        )


@pytest.mark.parametrize(("may_push", "counts"), [(False, (2, 0)), (True, (1, 1))])
def test_pushed_neighbours_are_counted_separately(may_push, counts, monkeypatch):
    pair = [
        object_on_table("box", (0.04, 0.04, 0.05), 0),
        object_on_table("box", (0.04, 0.04, 0.05), 0, name="other", offset=(0.1, 0.0)),
    ]
    cell, robot = trial_cell(pair, GraspTrial(known=True))
    scorer = Scorer(cell, robot)
    unfitted = SimpleNamespace(superquadric=None)
    target = SimpleNamespace(points=robot.object_pose("box").translation[None], fit=unfitted)
    plan = SimpleNamespace(
        prototype="pincer",
        approach="top",
        rows=6,
        may_push=may_push,
        geometry=None,
        score=SimpleNamespace(total=0.5),
    )
    report = SimpleNamespace(
        kind="box", outcome="stuck", reason="", perceive_ms=1.0, plan_ms=1.0, seconds=1.0,
        contact_pads=0, finger_curl=0.0, plan=plan,
    )  # fmt: skip
    choice = cast("SelectedGrasp", SimpleNamespace(target=target, plan=plan))
    scorer.on_pick(choice, None)
    monkeypatch.setattr(robot, "take_contacts", lambda: {"table", "box", "other"})
    scorer._note_cycle(cast("CycleInfo", SimpleNamespace(phase="pre-grasp")))
    scorer.on_pick(choice, cast("PickReport", report))
    (row,) = scorer._rows
    assert row.pushed == may_push
    assert (row.touched_before, row.touched_pushing) == counts
