"""Solids of several convex parts: L, T, hammer, dumbbell, mug with a handle, drill."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric
from eyehand.perception.superquadric import mesh, sample_surface

from ...mesh_file import join_meshes
from ...open3d_import import import_open3d

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


EDGE = 0.1
"""Exponent of sharp edges."""
RESOLUTION = 96
"""Facets around a part, for visibility."""
HIT_TOLERANCE = 0.0005
"""Largest distance of a visible point behind the first hit of its ray, m."""
ARM, THICKNESS, DEPTH = (0.04, 0.07), (0.012, 0.022), (0.015, 0.04)
"""Ranges of half extents of an L or T: length and thickness of the arms, and depth; m."""
HANDLE_RADIUS, HANDLE_LENGTH = (0.010, 0.016), (0.07, 0.12)
HEAD_LENGTH, HEAD_WIDTH = (0.04, 0.06), (0.014, 0.022)
BALL_RADIUS, BAR_LENGTH, BAR_SHARE = (0.022, 0.04), (0.035, 0.07), (0.35, 0.6)
MUG_RADIUS, MUG_HEIGHT, LOOP_THICKNESS = (0.032, 0.045), (0.04, 0.06), (0.005, 0.008)
BODY_RADIUS, BODY_LENGTH, GRIP_LENGTH, GRIP_TILT = (
    (0.022, 0.032),
    (0.06, 0.09),
    (0.045, 0.06),
    (0.0, 0.3),
)


@dataclass(frozen=True)
class CompoundSolid:
    """A union of superquadrics: a `TrueSolid`."""

    parts: tuple[Superquadric, ...]
    """The parts in the frame of the cloud."""
    pose: RigidTransform
    """Maps shape coordinates to the frame of the cloud."""

    @property
    def rotation(self) -> NDArray[np.float64]:
        """See TrueSolid."""
        return np.asarray(self.pose.rotation.as_matrix())

    @property
    def centre(self) -> NDArray[np.float64]:
        """See TrueSolid."""
        axes = self.rotation.T
        return 0.5 * (self.support(axes) - self.support(-axes)) @ axes

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """See TrueSolid."""
        return np.any([part.contains(points) for part in self.parts], axis=0)

    def support(self, directions: ArrayLike) -> NDArray[np.float64]:
        """See TrueSolid."""
        return np.max([part.support(directions) for part in self.parts], axis=0)

    def surface_points(
        self, origin: NDArray[np.float64] | None, count: int, rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """Draw points (count, 3) of the outer surface of the union, in random order.

        With an origin (3,) only points visible from there are drawn.
        """
        meshes = [mesh(part, RESOLUTION) for part in self.parts]
        areas = np.array([mesh_area(*surface) for surface in meshes])
        kept = np.zeros((0, 3))
        while len(kept) < count:
            shares = rng.multinomial(4 * count, areas / areas.sum())
            points = np.vstack([self._outer(index, n, rng) for index, n in enumerate(shares)])
            kept = np.vstack([kept, points[self._visible(points, origin)]])
        return kept[rng.permutation(len(kept))[:count]]

    def _outer(self, index: int, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw points of the surface of a part, without those inside other parts."""
        points = sample_surface(self.parts[index], count, rng)
        others = self.parts[:index] + self.parts[index + 1 :]
        return points[~np.any([other.contains(points) for other in others], axis=0)]

    @cached_property
    def _mesh(self) -> Mesh:
        """Vertices and faces of all parts, including hidden ones."""
        return join_meshes([mesh(part, RESOLUTION) for part in self.parts])

    def _visible(
        self, points: NDArray[np.float64], origin: NDArray[np.float64] | None
    ) -> NDArray[np.bool_]:
        if origin is None:
            return np.ones(len(points), dtype=bool)
        rays = np.hstack([np.zeros_like(points), points - origin]).astype(np.float32)
        scene = ray_scene(*self._mesh, origin)
        first = scene.cast_rays(import_open3d().core.Tensor(rays), nthreads=1)["t_hit"].numpy()
        # A ray has the length of the distance to its point, so a hit at 1 is the point.
        return (1.0 - first) * np.linalg.norm(points - origin, axis=1) < HIT_TOLERANCE


def draw_l_shape(rng: np.random.Generator) -> list[Superquadric]:
    """Draw a standing L."""
    (long, short), thick, deep = rng.uniform(*ARM, 2), rng.uniform(*THICKNESS), rng.uniform(*DEPTH)
    return [
        _box([thick, deep, long], [thick, 0.0, long]),
        _box([short, deep, thick], [short, 0.0, thick]),
    ]


def draw_t_shape(rng: np.random.Generator) -> list[Superquadric]:
    """Draw a standing T."""
    (long, wide), thick, deep = rng.uniform(*ARM, 2), rng.uniform(*THICKNESS), rng.uniform(*DEPTH)
    return [
        _box([thick, deep, long], [0.0, 0.0, long]),
        _box([wide, deep, thick], [0.0, 0.0, 2 * long]),
    ]


def draw_hammer(rng: np.random.Generator) -> list[Superquadric]:
    """Draw a lying hammer: a round handle with a square head across its end."""
    radius, length = rng.uniform(*HANDLE_RADIUS), rng.uniform(*HANDLE_LENGTH)
    head, wide = rng.uniform(*HEAD_LENGTH), max(rng.uniform(*HEAD_WIDTH), radius)
    return [_bar(radius, length, "x", [0.0] * 3), _box([wide, head, wide], [length, 0.0, 0.0])]


def draw_dumbbell(rng: np.random.Generator) -> list[Superquadric]:
    """Draw a lying dumbbell: two balls on a bar."""
    radius, length = rng.uniform(*BALL_RADIUS), rng.uniform(*BAR_LENGTH)
    ends = [length + 0.5 * radius, -length - 0.5 * radius]
    balls = [_solid([radius] * 3, (1.0, 1.0), [end, 0.0, 0.0]) for end in ends]
    return [_bar(radius * rng.uniform(*BAR_SHARE), length, "x", [0.0] * 3), *balls]


def draw_mug(rng: np.random.Generator) -> list[Superquadric]:
    """Draw an upright solid mug with a handle of three bars."""
    radius, height = rng.uniform(*MUG_RADIUS), rng.uniform(*MUG_HEIGHT)
    thick, reach, span = rng.uniform(*LOOP_THICKNESS), 0.35 * radius, 0.55 * height
    out = radius + 2 * reach
    return [
        _bar(radius, height, "z", [0.0] * 3),
        _box([thick, thick, span + thick], [out, 0.0, 0.0]),
        *(_box([reach + thick, thick, thick], [out - reach, 0.0, s * span]) for s in (-1, 1)),
    ]


def draw_drill(rng: np.random.Generator) -> list[Superquadric]:
    """Draw a drill: a lying body above a grip with a foot."""
    radius, length = rng.uniform(*BODY_RADIUS), rng.uniform(*BODY_LENGTH)
    grip, tilt = rng.uniform(*GRIP_LENGTH), rng.uniform(*GRIP_TILT)
    turn = Rotation.from_euler("y", tilt)
    behind = np.array([-0.5 * length, 0.0, 0.0])
    down = behind + turn.apply([0.0, 0.0, -grip])
    foot = behind + turn.apply([0.0, 0.0, -2 * grip])
    return [
        _bar(radius, length, "x", [0.0] * 3),
        _solid([0.018, 0.014, grip], (EDGE, 0.5), down, turn),
        _box([0.035, 0.025, 0.014], foot),
    ]


COMPOUNDS = {
    "L": draw_l_shape,
    "T": draw_t_shape,
    "hammer": draw_hammer,
    "dumbbell": draw_dumbbell,
    "mug": draw_mug,
    "drill": draw_drill,
}
"""Name → function that draws the parts of the shape as it stands on a table."""


def face_normals(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """Compute the outward normals (T, 3) of a mesh, with twice the area of a face as length."""
    first, second, third = np.moveaxis(vertices[faces], 1, 0)
    return np.cross(second - first, third - first)


def mesh_area(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> float:
    """Return the surface area of a mesh, m²."""
    return float(np.linalg.norm(face_normals(vertices, faces), axis=1).sum() / 2)


def ray_scene(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], origin: NDArray[np.float64]
) -> Any:
    """Return an open3d scene of a mesh relative to `origin` (3,).

    open3d computes in single precision, which is accurate enough near the origin.
    """
    open3d = import_open3d()
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(
        open3d.core.Tensor((vertices - origin).astype(np.float32)),
        open3d.core.Tensor(faces.astype(np.uint32)),
    )
    return scene


def posed_compound(parts: list[Superquadric], pose: RigidTransform) -> CompoundSolid:
    """Return the compound of these parts at a pose."""
    return CompoundSolid(
        tuple(Superquadric(p.semi_axes, p.exponents, pose * p.pose, p.kind) for p in parts), pose
    )


def _box(half: list[float], centre: ArrayLike) -> Superquadric:
    return _solid(half, (EDGE, EDGE), centre)


def _bar(radius: float, half_length: float, along: str, centre: ArrayLike) -> Superquadric:
    turn = Rotation.from_euler("y", np.pi / 2 if along == "x" else 0.0)
    return _solid([radius, radius, half_length], (EDGE, 1.0), centre, turn)


def _solid(
    semi_axes: list[float],
    exponents: tuple[float, float],
    centre: ArrayLike,
    turn: Rotation | None = None,
) -> Superquadric:
    pose = RigidTransform.from_components(centre, turn or Rotation.identity())
    return Superquadric(np.array(semi_axes), exponents, pose)
