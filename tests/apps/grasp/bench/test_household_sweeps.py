"""Sweeps of `eyehand stress grasp --objects`."""

import numpy as np
import pytest

from eyehand.apps.bench.stress import StressArguments
from eyehand.apps.grasp.bench import household_sweeps
from eyehand.apps.grasp.bench.stress import stress_grasp
from eyehand.apps.grasp.bench.stress_trial import stress_cell
from eyehand.apps.grasp.mesh_scenes import ObjectSource, mesh_scene
from eyehand.errors import InputError
from eyehand.grasping import PickOptions

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
SIDES = "1 2 4 3|5 7 8 6|1 5 6 2|3 4 8 7|1 3 7 5|2 6 8 4"


@pytest.fixture
def folder(tmp_path):
    """Folder with the mesh of a box of 40 x 50 x 120 mm."""
    vertices = CORNERS * [0.02, 0.025, 0.06]
    lines = [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in vertices]
    lines += [f"f {side}" for side in SIDES.split("|")]
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "box.obj").write_text("\n".join(lines) + "\n")
    return tmp_path / "objects"


@pytest.fixture
def stress(folder):
    (item,) = mesh_scene(ObjectSource(str(folder), density=400.0), "single", 3, 1)
    return stress_cell([item], 3, PickOptions(), known=False), item


def test_folder_without_objects_is_refused(tmp_path):
    with pytest.raises(InputError, match="no "):
        stress_grasp(StressArguments(), objects=tmp_path)


def test_hidden_share_of_object(stress):
    bench, item = stress
    height = bench.robot.world.cell.table.height
    seen = []
    for share in (0.0, 40.0, 80.0):
        household_sweeps._hide(bench, item, share)
        frame = bench.cell.robot.capture()
        points = frame.T_world_camera.apply(frame.points().reshape(-1, 3).astype(float))
        near = np.linalg.norm(points - bench.robot.object_pose(item.name).translation, axis=1)
        on_object = frame.valid.ravel() & (points[:, 2] > height + 0.004) & (near < item.radius)
        seen.append(int(on_object.sum()))
    assert seen[0] > 500
    assert seen[1] == pytest.approx(0.6 * seen[0], rel=0.1)
    assert seen[2] == pytest.approx(0.2 * seen[0], rel=0.2)


def test_mass_moves_along_the_longest_side(stress):
    bench, item = stress
    body = bench.robot.model.body(item.name).id
    before = bench.robot.model.body_ipos[body].copy()
    household_sweeps._shift_mass(bench, item, 50.0)
    assert bench.robot.model.body_ipos[body] - before == pytest.approx([0.0, 0.0, 0.03])


def test_soft_floor_lets_the_object_sink(stress):
    bench, item = stress
    before = bench.robot.object_pose(item.name).translation[2]
    household_sweeps._soften(bench, item, 2.0)
    bench.cell.wait(1.0)
    sunk = before - bench.robot.object_pose(item.name).translation[2]
    assert sunk == pytest.approx(0.002, rel=0.25)


def test_command_puts_the_unchanged_object_away(folder, tmp_path, capsys):
    code = stress_grasp(
        StressArguments(only=["balance"], quick=True, out=tmp_path / "out"), objects=folder
    )
    lines = (tmp_path / "out" / "stress.csv").read_text().splitlines()
    first = dict(zip(lines[0].split(","), lines[1].split(","), strict=True))
    assert first["placed_pct"] == "100.0"
    assert code == 0, capsys.readouterr().err
