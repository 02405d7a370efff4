"""Folders of meshes and URDFs: mass and pose of the objects, and errors with the file name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth.scenes.object_folder import DENSITY, read_objects
from eyehand.errors import InputError

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = [face for a, b, c, d in QUADS for face in ((a, b, c), (a, c, d))]


def write_box(path: Path, size: tuple[float, float, float], triangles=TRIANGLES) -> None:
    """Write a box with one corner at the origin as OBJ or text STL."""
    corners = CORNERS * size
    if path.suffix == ".obj":
        lines = [f"v {x} {y} {z}" for x, y, z in corners]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    else:
        lines = ["solid box"]
        for face in triangles:
            vertices = [f"vertex {x} {y} {z}" for x, y, z in corners[list(face)]]
            lines += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
        lines.append("endsolid box")
    path.write_text("\n".join(lines) + "\n")


def write_urdf(path: Path, content: str, links: int = 1) -> None:
    """Write a URDF with identical links."""
    link_elements = "".join(f"<link name='l{n}'>{content}</link>" for n in range(links))
    path.write_text(f"<robot name='r'>{link_elements}</robot>")


def test_meshes_are_read_as_objects(tmp_path):
    write_box(tmp_path / "carton.obj", (0.05, 0.06, 0.1))
    (tmp_path / "toys").mkdir()
    write_box(tmp_path / "toys" / "brick.stl", (0.04, 0.02, 0.02))
    carton, brick = read_objects(tmp_path)
    assert (carton.name, brick.name) == ("carton", "toys_brick")
    assert carton.mass == pytest.approx(DENSITY * 0.05 * 0.06 * 0.1)
    assert brick.mass == pytest.approx(DENSITY * 0.04 * 0.02 * 0.02)
    assert np.ptp(carton.vertices, axis=0) == pytest.approx([0.05, 0.06, 0.1])
    for item in (carton, brick):
        assert item.vertices.max(axis=0) == pytest.approx(-item.vertices.min(axis=0))
        assert item.faces.shape == (12, 3)


def test_mesh_object_is_accepted_by_mujoco(tmp_path):
    from eyehand.data_synth import import_mujoco

    write_box(tmp_path / "carton.obj", (0.05, 0.06, 0.1))
    (carton,) = read_objects(tmp_path)
    mujoco = import_mujoco()
    spec = mujoco.MjSpec()
    spec.add_mesh(name="m", uservert=carton.vertices.ravel(), userface=carton.faces.ravel())
    body = spec.worldbody.add_body(name="b")
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="m", mass=carton.mass)
    model = spec.compile()
    assert model.body("b").mass[0] == pytest.approx(carton.mass)
    assert model.body("b").ipos == pytest.approx(np.zeros(3), abs=1e-9)


def test_open_mesh_has_mass_of_its_hull(tmp_path):
    write_box(tmp_path / "open.obj", (0.05, 0.05, 0.05), TRIANGLES[2:])
    (item,) = read_objects(tmp_path)
    assert item.mass == pytest.approx(DENSITY * 0.05**3)


def test_urdf_gives_mass_scale_and_pose(tmp_path):
    write_box(tmp_path / "part.stl", (50, 60, 100))
    write_urdf(
        tmp_path / "carton.urdf",
        "<inertial><mass value='0.3'/></inertial><collision>"
        "<origin xyz='0 0 0.1' rpy='0 1.5707963267948966 0'/><geometry>"
        "<mesh filename='package://part.stl' scale='0.001 0.001 0.001'/></geometry></collision>",
    )
    write_urdf(
        tmp_path / "dumbbell.urdf",
        "<visual><geometry><sphere radius='0.02'/></geometry></visual>"
        "<visual><origin xyz='0 0 0.1'/><geometry><box size='.04 .04 .04'/></geometry></visual>",
    )
    carton, dumbbell = read_objects(tmp_path)
    assert carton.mass == 0.3
    assert np.ptp(carton.vertices, axis=0) == pytest.approx([0.1, 0.06, 0.05])
    assert np.ptp(dumbbell.vertices, axis=0) == pytest.approx([0.04, 0.04, 0.14], abs=1e-3)


@pytest.mark.parametrize(
    ("size", "message"),
    [
        ((50, 60, 100), r"box\.obj is 100 m long.*in mm, scale it by 0\.001"),
        ((2, 0.1, 0.1), r"box\.obj is 2 m long, expected at most 0\.6 m$"),
        ((0.004, 0.004, 0.004), r"box\.obj is 0\.004 m long, expected at least"),
        ((0.1, 0.1, 0.0), r"box\.obj is 0 m thick"),
        ((0.1, float("nan"), 0.1), r"box\.obj"),
        ((0.011, 0.0011, 0.0011), r"box\.obj has a mass of 5\.\d+e-06 kg"),
    ],
)
def test_unlikely_sizes_raise_with_file_name(tmp_path, size, message):
    write_box(tmp_path / "box.obj", size)
    with pytest.raises(InputError, match=message):
        read_objects(tmp_path)


@pytest.mark.parametrize(
    ("content", "links", "message"),
    [
        ("", 1, "neither collision nor visual"),
        ("<visual><geometry/></visual>", 1, "geometry is empty"),
        ("<visual><geometry><box size='1 2'/></geometry></visual>", 1, "expected 3 finite numbers"),
        ("<visual><geometry><cone/></geometry></visual>", 1, "is 'cone', expected box"),
        (
            "<visual><geometry><mesh filename='no.stl'/></geometry></visual>",
            1,
            "'no.stl' that does not",
        ),
        ("", 2, "has 2 links, expected a URDF of one rigid link"),
    ],
)
def test_invalid_urdf_raises(tmp_path, content, links, message):
    write_urdf(tmp_path / "thing.urdf", content, links)
    with pytest.raises(InputError, match=f"thing.urdf.*{message}"):
        read_objects(tmp_path)


@pytest.mark.parametrize("name", ["a.obj", "a.stl", "a.urdf"])
def test_file_of_another_format_raises_with_name(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00\x01 this is no mesh <<")
    with pytest.raises(InputError, match=name):
        read_objects(tmp_path)


def test_missing_or_empty_folder_raises(tmp_path):
    with pytest.raises(InputError, match="there is no folder"):
        read_objects(tmp_path / "none")
    with pytest.raises(InputError, match="contains no objects"):
        read_objects(tmp_path)


def test_duplicate_object_names_raise(tmp_path):
    for name in ("box.obj", "box.stl"):
        write_box(tmp_path / name, (0.05, 0.05, 0.05))
    with pytest.raises(InputError, match="another file has the same object name, box"):
        read_objects(tmp_path)


def test_density_replaces_the_mass_of_the_file(tmp_path):
    write_box(tmp_path / "part.obj", (0.05, 0.06, 0.1))
    write_urdf(
        tmp_path / "carton.urdf",
        "<inertial><mass value='0.3'/></inertial><collision>"
        "<geometry><mesh filename='part.obj'/></geometry></collision>",
    )
    assert read_objects(tmp_path)[0].mass == 0.3
    assert read_objects(tmp_path, 500.0)[0].mass == pytest.approx(500.0 * 0.05 * 0.06 * 0.1)


def test_convex_parts_are_kept_as_pieces(tmp_path):
    write_urdf(
        tmp_path / "tongs.urdf",
        "<visual><geometry><box size='.02 .1 .02'/></geometry></visual>"
        "<visual><origin xyz='0.06 0 0'/><geometry><box size='.02 .1 .02'/></geometry></visual>",
    )
    (tongs,) = read_objects(tmp_path, 500.0)
    assert [len(piece) for piece in tongs.pieces] == [8, 8]
    assert np.ptp(np.concatenate(tongs.pieces), axis=0) == pytest.approx([0.08, 0.1, 0.02])
    assert tongs.mass == pytest.approx(500.0 * 2 * 0.02 * 0.1 * 0.02)


def test_pieces_with_equal_corners_stay_apart(tmp_path):
    """The foot and the upright plate of an angle share four corners; their union is not convex."""
    foot, plate = CORNERS * (0.1, 0.05, 0.02), CORNERS * (0.02, 0.05, 0.1)
    plate[:, 0] *= -1.0
    mirrored = [(a, c, b) for a, b, c in TRIANGLES]
    plate[CORNERS[:, 2] == 0.0, 2] = 0.02
    foot[CORNERS[:, 0] == 0.0, 0] = -0.02
    lines = [f"v {x} {y} {z}" for x, y, z in [*foot, *plate]]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TRIANGLES]
    lines += [f"f {a + 9} {b + 9} {c + 9}" for a, b, c in mirrored]
    (tmp_path / "angle.obj").write_text("\n".join(lines) + "\n")
    (angle,) = read_objects(tmp_path)
    assert [len(piece) for piece in angle.pieces] == [8, 8]
    merged = {tuple(corner) for piece in angle.pieces for corner in np.round(piece, 6)}
    assert len(merged) == 14


def test_open_surface_has_no_pieces(tmp_path):
    write_box(tmp_path / "open.obj", (0.05, 0.05, 0.05), TRIANGLES[2:])
    assert read_objects(tmp_path)[0].pieces == ()
