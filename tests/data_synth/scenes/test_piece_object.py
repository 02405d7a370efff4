"""Objects of convex pieces from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from eyehand.data_synth.scenes import read_piece_objects

SHARED = Path(__file__).resolve().parents[4] / "shared" / "data" / "objects"


def _cube(x: float, first: int) -> str:
    corners = [(x + 0.02 * i, 0.02 * j, 0.02 * k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    lines = [f"v {a} {b} {c}" for a, b, c in corners]
    lines += ["f " + " ".join(str(int(k) + first) for k in face.split()) for face in faces]
    return "\n".join(lines) + "\n"


def test_each_connected_part_is_a_piece(tmp_path):
    (tmp_path / "two.obj").write_text(_cube(0.0, 0) + _cube(0.05, 8))
    (item,) = read_piece_objects(tmp_path)
    assert len(item.pieces) == 2
    assert {len(piece) for piece in item.pieces} == {8}
    assert np.ptp(item.corners[:, 0]) == pytest.approx(0.07)
    small = item.scaled(0.5)
    assert np.ptp(small.corners[:, 0]) == pytest.approx(0.035)
    assert small.mass == item.mass


def test_pieces_are_found_in_a_mesh_that_repeats_corners(tmp_path):
    """Each triangle of an STL file is a part of its own."""
    low, high = (trimesh.creation.box((0.04, 0.06, size)) for size in (0.08, 0.02))
    high.apply_translation([0.0, 0.0, 0.06])
    trimesh.util.concatenate([low, high]).export(tmp_path / "two.stl")
    (item,) = read_piece_objects(tmp_path)
    sizes = sorted(np.ptp(piece, axis=0)[2] for piece in item.pieces)
    np.testing.assert_allclose(sizes, [0.02, 0.08], atol=1e-6)


def test_open_surface_is_its_hull(tmp_path):
    mesh = trimesh.creation.box((0.04, 0.06, 0.08))
    mesh.update_faces(np.arange(len(mesh.faces)) > 1)
    mesh.export(tmp_path / "box.obj")
    (item,) = read_piece_objects(tmp_path)
    (piece,) = item.pieces
    np.testing.assert_allclose(np.ptp(piece, axis=0), [0.04, 0.06, 0.08])


def test_density_replaces_the_mass_of_the_file(tmp_path):
    (tmp_path / "one.obj").write_text(_cube(0.0, 0))
    (item,) = read_piece_objects(tmp_path, density=700.0)
    assert item.mass == pytest.approx(700.0 * 0.02**3)


def test_pieces_are_the_groups_of_the_shared_files():
    folder = SHARED / "pile"
    if not folder.is_dir():
        pytest.skip(f"no {folder}")
    for item in read_piece_objects(folder):
        text = (folder / f"{item.name}_collision.obj").read_text()
        groups = sum(line.startswith("o ") for line in text.splitlines())
        assert len(item.pieces) == groups
