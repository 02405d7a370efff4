"""Tests of sampling mesh surfaces: on the surface, uniform, reproducible."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.perception.io.mesh import is_closed, read_mesh, sample_surface

DATA = Path(__file__).parents[3] / ".." / "shared" / "data"

# A unit cube of quadrilaterals, with every index syntax of OBJ.
CUBE = b"""mtllib absent.mtl
o cube
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
usemtl nothing
f 1 2 3 4
f 5/1 6/2 7/3 8/4
f 1//1 2//1 6//1 5//1
f -6 -5 -1 -2
f 1 4 8 5
f 2 3 7 6
"""

PLY_SQUARE = (
    b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    b"0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n"
)


def _sample(tmp_path: Path, name: str, data: bytes, samples: int = 2000) -> np.ndarray:
    (tmp_path / name).write_bytes(data)
    return sample_surface(tmp_path / name, samples, seed=1)


def _triangle_stl(count: int, declared: int) -> bytes:
    triangle = struct.pack("<12fH", *(0, 0, 1), *(0, 0, 0), *(1, 0, 0), *(0, 1, 0), 0)
    return b"\0" * 80 + struct.pack("<I", declared) + triangle * count


def test_cube_faces_are_sampled_evenly(tmp_path: Path) -> None:
    points = _sample(tmp_path, "a.obj", CUBE, 6000)
    assert points.shape == (6000, 3)
    assert points.min() >= -1e-12
    assert points.max() <= 1 + 1e-12
    sides = [np.count_nonzero(np.isclose(points[:, i], at)) for i in range(3) for at in (0, 1)]
    assert sum(sides) == 6000
    # 1000 each, standard deviation 29.
    assert np.ptp(sides) < 6 * 29


def test_closed_surface_may_lack_its_bottom_but_not_half_its_sides(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_bytes(CUBE)
    corners, triangles = read_mesh(tmp_path / "a.obj")
    a, b, c = (corners[triangles[:, k]] - 0.5 for k in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    assert is_closed(corners, triangles)
    assert is_closed(corners, triangles[2:])
    assert not is_closed(corners, triangles[corners[triangles].min(axis=1).max(axis=1) == 0.0])
    assert not is_closed(corners, triangles[:0])


def test_samples_are_proportional_to_area(tmp_path: Path) -> None:
    text = b"v 0 0 0\nv 3 0 0\nv 0 3 0\nv 9 9 9\nv 10 9 9\nv 9 10 9\nf 1 2 3\nf 1 1 1\nf 4 5 6\n"
    points = _sample(tmp_path, "a.obj", text, 5000)
    assert 400 < np.count_nonzero(points[:, 2] == 9) < 600


def test_samples_are_uniform_within_triangle(tmp_path: Path) -> None:
    points = _sample(tmp_path, "a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 20_000)
    assert (points[:, :2].sum(axis=1) <= 1).all()
    np.testing.assert_allclose(points.mean(axis=0), [1 / 3, 1 / 3, 0], atol=0.01)
    # The corner triangle with half the side length has a quarter of the area.
    assert abs(np.mean(points[:, 0] > 0.5) - 0.25) < 0.015


def test_same_seed_gives_same_points(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_bytes(CUBE)
    first, second, other = (sample_surface(tmp_path / "a.obj", 50, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)


def test_obj_without_faces_gives_vertices(tmp_path: Path) -> None:
    points = _sample(tmp_path, "a.obj", b"v 1 2 3 1.0\nv 4 5 6\n")
    np.testing.assert_array_equal(points, [[1, 2, 3], [4, 5, 6]])


def test_text_and_binary_stl_are_sampled(tmp_path: Path) -> None:
    text = (
        b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        b"endloop\nendfacet\nendsolid a\n"
    )
    for data in (_triangle_stl(1, 1), text):
        points = _sample(tmp_path, "a.stl", data)
        assert (points[:, :2].sum(axis=1) <= 1 + 1e-12).all()
        np.testing.assert_allclose(points.mean(axis=0), [1 / 3, 1 / 3, 0], atol=0.03)


def test_ply_faces_are_sampled(tmp_path: Path) -> None:
    points = _sample(tmp_path, "a.ply", PLY_SQUARE)
    np.testing.assert_allclose(points.mean(axis=0), [1, 0.5, 0], atol=0.05)
    np.testing.assert_allclose(points.max(axis=0), [2, 1, 0], atol=0.02)


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.obj", b"hello\nworld\n", r"a\.obj: not an OBJ file: it has no vertex"),
        ("a.obj", b"v 1 2\n", "line 1 is 'v 1 2' .*expected `v x y z`"),
        ("a.obj", b"v 1 2 three\n", "line 1 is 'v 1 2 three'"),
        ("a.obj", b"v 1 2 nan\n", "1 vertices are NaN or infinite"),
        ("a.obj", b"v 1 2 3\nf 1 1\n", "a face has 2 corners, expected at least 3"),
        ("a.obj", b"v 1 2 3\nf 0 1 1\n", "there is no vertex 0"),
        ("a.obj", b"v 1 2 3\nf 1 1 -2\n", "there is no vertex -2"),
        ("a.obj", b"v 1 2 3\nf 1 1 2\n", "faces name vertices 0 to 1, expected 0 to 0"),
        ("a.obj", b"v 1 2 3\nf 1 1 1\n", "surface measures 0 m², expected a finite area > 0"),
        ("a.obj", b"v 1e200 0 0\nv 0 1e200 0\nv 0 0 0\nf 1 2 3\n", "surface measures inf m²"),
        (
            "a.stl",
            _triangle_stl(1, 3),
            r"a\.stl: not a whole STL .* \(134 bytes, expected 234 for the 3",
        ),
        ("a.stl", b"solid a\nfacet\n", r"not a whole STL file with triangles \(14 bytes\)"),
        ("a.stl", bytes(range(256)) * 4, "not a whole STL file"),
        (
            "a.ply",
            PLY_SQUARE.replace(b"2 3\n", b"2 9\n"),
            "table refers to vertices 0 to 9, exp",
        ),
        ("a.ply", PLY_SQUARE.replace(b"4 0", b"2 0"), "a face has 2 corners, expected at least 3"),
        ("a.ply", PLY_SQUARE[:-5], "a PLY row is '4 0 1', expected a list"),
        ("a.ply", PLY_SQUARE[:-10], "truncated: 0 of 1 rows of face"),
        ("a.ply", PLY_SQUARE.replace(b"2 1 0", b"2 1 nan"), "1 vertices are NaN or infinite"),
    ],
)
def test_files_without_surface_are_rejected(
    tmp_path: Path, name: str, data: bytes, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        _sample(tmp_path, name, data)


def test_zero_samples_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="samples must be >= 1, got 0"):
        _sample(tmp_path, "a.obj", CUBE, 0)


@pytest.mark.skipif(
    not (DATA / "objects").is_dir(), reason="third-party meshes (../shared/data) are absent"
)
def test_samples_of_real_meshes_lie_in_bounding_box() -> None:
    meshes = sorted((DATA / "objects").glob("*/*_visual.obj"))
    assert meshes
    for mesh in meshes:
        vertices = np.array(
            [line.split()[1:4] for line in mesh.read_text().splitlines() if line.startswith("v ")],
            dtype=float,
        )
        points = sample_surface(mesh, 500, seed=0)
        assert (points >= vertices.min(axis=0) - 1e-9).all()
        assert (points <= vertices.max(axis=0) + 1e-9).all()
