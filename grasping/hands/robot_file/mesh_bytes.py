"""Contents of mesh files in a format that MuJoCo reads: binary STL and OBJ."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

MAX_MESH_BYTES = 200_000_000
"""Maximum size of a mesh file."""
STL_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""Triangle of a binary STL file."""
FLATNESS, THICKNESS = 1e-5, 1e-3
"""Thickness below which a mesh is flat, and that it is given then, as shares of its size."""
READABLE = ".stl, .obj, .dae, .glb, .ply"


def mesh_bytes(path: Path) -> tuple[str, bytes]:
    """Return the suffix and the contents of a mesh; all but OBJ become binary STL.

    Raises
    ------
    InputError
        If the file cannot be read, or its format is none of :data:`READABLE`.
    """
    try:
        if path.stat().st_size > MAX_MESH_BYTES:
            raise InputError(f"mesh {path} is larger than {MAX_MESH_BYTES / 1e6:.0f} MB")
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the mesh {path}: {error.strerror}") from None
    suffix = path.suffix.lower()
    if suffix == ".obj":
        return suffix, content
    if suffix == ".stl":
        if not _is_binary_stl(content):
            corners = _text_stl(path, content)
        else:
            corners = np.frombuffer(content, STL_RECORD, _stl_count(content), 84)["corners"]
            if not _is_flat(corners):
                return suffix, content
        return suffix, _binary_stl(corners)
    if suffix == ".dae":
        return ".stl", _binary_stl(_collada(path, content))
    if suffix in (".glb", ".ply"):
        return ".stl", _binary_stl(_other_mesh(path, content))
    raise InputError(f"mesh {path} has the format {suffix or 'none'}; readable are {READABLE}")


def _is_binary_stl(content: bytes) -> bool:
    if len(content) < 84:
        return False
    return len(content) >= 84 + 50 * _stl_count(content) and not (
        content[:5] == b"solid" and b"facet" in content[:1000]
    )


def _stl_count(content: bytes) -> int:
    return struct.unpack_from("<I", content, 80)[0]


def _text_stl(path: Path, content: bytes) -> NDArray[np.float64]:
    """Return the triangles (T, 3, 3) of a text STL."""
    words = [line.split()[1:4] for line in content.splitlines() if line.split()[:1] == [b"vertex"]]
    try:
        corners = np.array(words, dtype=np.float64).reshape(-1, 3, 3)
    except ValueError:
        raise InputError(f"mesh {path} is no valid STL file") from None
    if not len(corners) or not np.isfinite(corners).all():
        raise InputError(f"mesh {path} has no triangles, or corners that are not finite")
    return corners


def _binary_stl(corners: NDArray[np.float64]) -> bytes:
    """Encode triangles (T, 3, 3) as binary STL. A flat shape becomes a thin one with two faces."""
    if _is_flat(corners):
        normal, size = _thinnest(corners)
        corners = np.concatenate([corners, corners + THICKNESS * size * normal])
    record = np.zeros(len(corners), STL_RECORD)
    record["corners"] = corners
    return b"\0" * 80 + struct.pack("<I", len(corners)) + record.tobytes()


def _is_flat(corners: NDArray[np.floating]) -> bool:
    """Return whether all triangles (T, 3, 3) lie in one plane. MuJoCo finds no hull of them."""
    if not len(corners) or not np.isfinite(corners).all():
        return False
    normal, size = _thinnest(corners)
    return float(np.ptp(corners.reshape(-1, 3) @ normal)) < FLATNESS * size


def _thinnest(corners: NDArray[np.floating]) -> tuple[NDArray[np.float64], float]:
    """Return the direction (3,) in which a shape is thinnest, and its size."""
    points = corners.reshape(-1, 3).astype(np.float64)
    points = points - points.mean(axis=0)
    return np.linalg.eigh(points.T @ points)[1][:, 0], float(np.ptp(points, axis=0).max())


def mesh_shape(name: str, content: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return vertices (V, 3) in m and triangles (T, 3) of a mesh; the suffix says the format."""
    import trimesh

    kind = name.rpartition(".")[2].lower()
    mesh = trimesh.load_scene(io.BytesIO(content), file_type=kind).to_mesh()
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int32)


def _other_mesh(path: Path, content: bytes) -> NDArray[np.float64]:
    """Return the triangles (T, 3, 3) of a GLB or PLY file, with its axes as they are."""
    try:
        vertices, faces = mesh_shape(path.name, content)
        corners = vertices[faces]
    except Exception as error:  # The readers raise whatever a broken file leads to.
        raise InputError(f"mesh {path} cannot be read: {' '.join(str(error).split())}") from None
    if not len(corners) or not np.isfinite(corners).all():
        raise InputError(f"mesh {path} has no triangles, or corners that are not finite")
    return corners


def _collada(path: Path, content: bytes) -> NDArray[np.float64]:
    """Return the triangles (T, 3, 3) of a COLLADA file, m, with z up.

    Read are triangles and polygons of geometries that the scene places. Skins and lines are not.
    """
    try:
        root = ElementTree.fromstring(content)
        for element in root.iter():
            element.tag = str(element.tag).rpartition("}")[2]
        unit = root.find("asset/unit")
        scale = 1.0 if unit is None else float(unit.get("meter", "1"))
        meshes = {
            str(one.get("id")): _collada_mesh(mesh)
            for one in root.iter("geometry")
            for mesh in one.findall("mesh")
        }
        placed: list[NDArray[np.float64]] = []
        for scene in root.iter("visual_scene"):
            for node in scene.findall("node"):
                _place(node, np.eye(4), meshes, placed)
        corners = np.concatenate(placed or list(meshes.values()))
    except (ElementTree.ParseError, ValueError, KeyError, IndexError, AttributeError) as error:
        raise InputError(f"mesh {path} is no COLLADA file that can be read: {error}") from None
    if not len(corners) or not np.isfinite(corners).all():
        raise InputError(f"mesh {path} has no triangles, or corners that are not finite")
    up = root.findtext("asset/up_axis", "Y_UP").strip()
    if up == "Y_UP":
        corners = corners[..., [0, 2, 1]] * [1.0, -1.0, 1.0]
    return corners * scale


def _collada_mesh(mesh: ElementTree.Element) -> NDArray[np.float64]:
    sources = {}
    for source in mesh.findall("source"):
        array = source.find("float_array")
        if array is not None:
            sources[f"#{source.get('id')}"] = np.array((array.text or "").split(), dtype=np.float64)
    for vertices in mesh.findall("vertices"):
        for item in vertices.findall("input"):
            if item.get("semantic") == "POSITION":
                sources[f"#{vertices.get('id')}"] = sources[str(item.get("source"))]
    parts = [np.zeros((0, 3, 3))]
    for piece in (*mesh.findall("triangles"), *mesh.findall("polylist")):
        inputs = piece.findall("input")
        width = 1 + max(int(item.get("offset", "0")) for item in inputs)
        vertex = next(item for item in inputs if item.get("semantic") == "VERTEX")
        points = sources[str(vertex.get("source"))].reshape(-1, 3)
        index = np.array((piece.findtext("p") or "").split(), dtype=np.int64).reshape(-1, width)
        corners = points[index[:, int(vertex.get("offset", "0"))]]
        counts = piece.findtext("vcount")
        parts.append(
            corners.reshape(-1, 3, 3) if counts is None else _fans(corners, counts.split())
        )
    return np.concatenate(parts)


def _fans(corners: NDArray[np.float64], counts: list[str]) -> NDArray[np.float64]:
    """Cut polygons into triangles (T, 3, 3)."""
    triangles, start = [np.zeros((0, 3, 3))], 0
    for count in map(int, counts):
        polygon = corners[start : start + count]
        start += count
        if count >= 3:
            first = np.broadcast_to(polygon[0], (count - 2, 3))
            triangles.append(np.stack([first, polygon[1:-1], polygon[2:]], axis=1))
    return np.concatenate(triangles)


def _place(
    node: ElementTree.Element,
    above: NDArray[np.float64],
    meshes: dict[str, NDArray[np.float64]],
    placed: list[NDArray[np.float64]],
) -> None:
    """Add the geometries of a node and its children, in the scene's frame."""
    pose = above.copy()
    for step in node:
        numbers = (
            np.array((step.text or "").split() or [0.0], dtype=np.float64)
            if (step.tag in ("matrix", "translate", "rotate", "scale"))
            else np.zeros(0)
        )
        if step.tag == "matrix":
            pose = pose @ numbers.reshape(4, 4)
        elif step.tag == "translate":
            move = np.eye(4)
            move[:3, 3] = numbers
            pose = pose @ move
        elif step.tag == "scale":
            pose = pose @ np.diag([*numbers, 1.0])
        elif step.tag == "rotate":
            from scipy.spatial.transform import Rotation

            turn = np.eye(4)
            axis = numbers[:3] / max(float(np.linalg.norm(numbers[:3])), 1e-12)
            turn[:3, :3] = Rotation.from_rotvec(np.deg2rad(numbers[3]) * axis).as_matrix()
            pose = pose @ turn
    for item in node.findall("instance_geometry"):
        corners = meshes.get(str(item.get("url")).lstrip("#"))
        if corners is not None:
            placed.append(corners @ pose[:3, :3].T + pose[:3, 3])
    for child in node.findall("node"):
        _place(child, pose, meshes, placed)
