"""Tests of reading and writing point clouds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from eyehand.errors import InputError
from eyehand.perception.io.pcd import read_pcd
from eyehand.perception.io.ply import read_ply
from eyehand.perception.io.point_cloud import read_cloud, write_cloud

DATA = Path(__file__).parents[3] / ".." / "shared" / "data"

coordinates = st.floats(-50, 50)
clouds = hnp.arrays(np.float64, st.tuples(st.integers(1, 20), st.just(3)), elements=coordinates)


@pytest.mark.parametrize("suffix", [".npz", ".xyz", ".ply", ".pcd", ".PLY"])
@settings(deadline=None, max_examples=15)
@given(points=clouds, coloured=st.booleans())
def test_points_round_trip_in_every_format(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, points: np.ndarray, coloured: bool
) -> None:
    path = tmp_path_factory.mktemp("cloud") / f"a{suffix}"
    colours = np.full(points.shape, 7, dtype=np.uint8) if coloured else None
    assert write_cloud(path, points, colours) == path
    back = read_cloud(path)
    assert back.dtype == np.float64
    exact = suffix in (".npz", ".xyz")
    np.testing.assert_array_equal(back, points if exact else points.astype(np.float32))


def test_colours_are_written(tmp_path: Path) -> None:
    points = np.zeros((2, 3))
    colours = np.array([[255, 0, 1], [2, 3, 4]], dtype=np.uint8)
    for suffix in (".ply", ".pcd", ".npz", ".xyz"):
        write_cloud(tmp_path / f"a{suffix}", points, colours)
    np.testing.assert_array_equal(read_ply(tmp_path / "a.ply").colours, colours)
    np.testing.assert_array_equal(read_pcd(tmp_path / "a.pcd").colours, colours)
    np.testing.assert_array_equal(np.load(tmp_path / "a.npz")["colours"], colours)
    assert (tmp_path / "a.xyz").read_text().splitlines()[0] == "0.0 0.0 0.0 255 0 1"


def test_points_without_reading_are_skipped(tmp_path: Path) -> None:
    points = np.array([[1, 2, 3], [np.nan, 0, 0], [0, np.inf, 0], [4, 5, 6]])
    np.savez(tmp_path / "a.npz", points=points)
    (tmp_path / "a.csv").write_text("\n".join(",".join(map(str, row)) for row in points))
    for name in ("a.npz", "a.csv"):
        np.testing.assert_array_equal(read_cloud(tmp_path / name), [[1, 2, 3], [4, 5, 6]])


def test_integer_points_are_read_as_metres(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", points=np.array([[1, 2, 3]]))
    assert read_cloud(tmp_path / "a.npz").tolist() == [[1.0, 2.0, 3.0]]


def test_meshes_give_requested_number_of_samples(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    points = read_cloud(tmp_path / "a.obj", samples=321)
    assert points.shape == (321, 3)
    np.testing.assert_array_equal(points, read_cloud(tmp_path / "a.obj", samples=321, seed=0))


def test_ply_is_mesh_only_with_faces(tmp_path: Path) -> None:
    header = (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n"
    )
    (tmp_path / "a.ply").write_text(header.format(0))
    np.testing.assert_array_equal(read_cloud(tmp_path / "a.ply"), [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    (tmp_path / "a.ply").write_text(header.format(1) + "3 0 1 2\n")
    assert read_cloud(tmp_path / "a.ply", samples=77).shape == (77, 3)


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.las", b"x", r"a\.las: suffix '\.las' is no cloud format, .*\.ply, \.pcd, .*\.stl"),
        ("a.pcd", b"junk\n", r"a\.pcd: not a PCD file"),
        ("a.ply", b"junk\n", r"a\.ply: not a PLY file"),
        ("a.npz", b"junk", r"a\.npz: not a whole \.npz archive"),
        ("a.xyz", b"junk\n", r"a\.xyz: first line is 'junk', expected numbers"),
        ("a.txt", b"nan nan nan\n", r"a\.txt: none of its 1 points is finite"),
        ("a.csv", b"", r"a\.csv: the file is empty"),
        ("a.obj", b"junk\n", r"a\.obj: not an OBJ file"),
        ("a.stl", b"junk\n", r"a\.stl: not a whole STL file"),
    ],
)
def test_invalid_cloud_files_are_rejected(
    tmp_path: Path, name: str, data: bytes, message: str
) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=message) as caught:
        read_cloud(tmp_path / name)
    assert "\n" not in str(caught.value)


def test_missing_file_is_reported(tmp_path: Path) -> None:
    for suffix in (".ply", ".pcd", ".npz", ".xyz", ".obj", ".stl"):
        with pytest.raises(InputError, match=rf"absent\{suffix}: no such file"):
            read_cloud(tmp_path / f"absent{suffix}")


@pytest.mark.parametrize("points", [np.zeros(3), np.zeros((3, 2)), np.full((1, 3), "a")])
def test_arrays_of_wrong_shape_are_rejected(tmp_path: Path, points: np.ndarray) -> None:
    np.savez(tmp_path / "a.npz", points=points)
    with pytest.raises(InputError, match=r"a\.npz: points are .*, expected \(N, 3\) float"):
        read_cloud(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("points", "colours", "message"),
    [
        (np.zeros((2, 2)), None, r"points are \(2, 2\) float64, expected \(N, 3\) float"),
        (np.zeros((0, 3)), None, "0 of 0 points are NaN or infinite, expected at least 1 point"),
        ([[0, 0, np.nan]], None, "1 of 1 points are NaN or infinite"),
        ([[0, 0, 1e300]], None, "too large for a float32 file"),
        (np.zeros((2, 3)), np.zeros((2, 3)), r"colours are \(2, 3\) float64, expected .* uint8"),
    ],
)
def test_invalid_arrays_are_not_written(
    tmp_path: Path, points: Any, colours: Any, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        write_cloud(tmp_path / "a.ply", points, colours)
    assert list(tmp_path.iterdir()) == []


def test_write_reports_formats(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"suffix '\.obj' .*expected one of \.ply, \.pcd, \.npz"):
        write_cloud(tmp_path / "a.obj", np.zeros((1, 3)))


@pytest.mark.skipif(
    not (DATA / "frames").is_dir(), reason="third-party frames (../shared/data) are absent"
)
def test_real_carton_cloud_is_read() -> None:
    points = read_cloud(DATA / "frames/pcl/milk_color.pcd")
    assert points.shape == (13704, 3)
    assert np.all(np.ptp(points, axis=0) < 0.3)
    organised = read_cloud(DATA / "frames/pcl/milk_cartoon_all_small_clorox.pcd")
    assert organised.shape == (307200 - 65793, 3)


def test_coordinates_beyond_any_place_on_earth_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", points=np.array([[0.0, 0.0, 1.0], [0.0, -1e308, 0.0]]))
    with pytest.raises(InputError, match=r"a\.npz: a coordinate is 1e\+308 m, expected at most"):
        read_cloud(tmp_path / "a.npz")
