"""Objects of `eyehand experiment force-closure`: long solids of one or two convex pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.scenes import MeshObject, TabletopObject
from eyehand.perception.superquadric import Superquadric

PLACE, TURN = (0.0, 0.05), 0.3
"""Position, m, and rotation about the vertical, rad, of the object on the table."""
COLOUR = (0.75, 0.45, 0.25)
OBJECT = "object"
"""Name of the object in the simulation."""
FACETS = 32
"""Facets of a round piece."""


@dataclass(frozen=True)
class Piece:
    """A box, or a cylinder along x."""

    middle: float
    """Centre along the object, m."""
    size: tuple[float, float, float]
    """Extents along the object, across it and upwards, m."""
    round: bool = False
    """Whether it is a cylinder along the object."""

    def vertices(self) -> NDArray[np.float64]:
        """Return its corners, (V, 3), m."""
        angle = np.arange(FACETS) * 2.0 * np.pi / FACETS
        ring = np.column_stack([np.cos(angle), np.sin(angle)])
        if not self.round:
            ring = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])
        half = 0.5 * np.array(self.size)
        ends = [np.column_stack([np.full(len(ring), end), ring]) for end in (-1.0, 1.0)]
        return np.concatenate(ends) * half + [self.middle, 0.0, 0.0]

    def volume(self) -> float:
        """Return its volume, m³."""
        return float(np.prod(self.size)) * (0.25 * np.pi if self.round else 1.0)


@dataclass(frozen=True)
class ClosureShape:
    """A shape, and where its mass is."""

    name: str
    """Name in the table."""
    pieces: tuple[Piece, ...]
    """Its pieces. The first one is gripped."""
    shares: tuple[float, ...] = ()
    """Share of the mass of each piece; empty for one density."""

    @property
    def width(self) -> float:
        """Width of the gripped piece, m."""
        return self.pieces[0].size[1]

    @property
    def seen_centre(self) -> float:
        """Centre of mass along the object for one density, as a camera would estimate it, m."""
        volumes = [piece.volume() for piece in self.pieces]
        return float(np.average([piece.middle for piece in self.pieces], weights=volumes))

    @property
    def centre(self) -> float:
        """True centre of mass along the object, m."""
        if not self.shares:
            return self.seen_centre
        return float(np.average([piece.middle for piece in self.pieces], weights=self.shares))

    @property
    def pose(self) -> RigidTransform:
        """T_world_object at the start. x is the long axis, z is up."""
        half = 0.5 * self.pieces[0].size[2]
        return RigidTransform.from_components([*PLACE, half], Rotation.from_euler("z", TURN))

    def world_object(self, mass: float) -> MeshObject:
        """Return the object of the simulation."""
        clouds = tuple(piece.vertices() for piece in self.pieces)
        faces, first = [], 0
        for cloud in clouds:
            faces.append(ConvexHull(cloud).simplices + first)
            first += len(cloud)
        return MeshObject(
            OBJECT, np.concatenate(clouds), np.concatenate(faces), mass, COLOUR, self.pose,
            clouds if len(clouds) > 1 else (), self.shares,
        )  # fmt: skip

    def perceived_object(self, mass: float, error: float) -> TabletopObject:
        """Return a solid as perception would find it.

        Its centre is `seen_centre` with an ``error`` along the object, m.
        """
        centre = self.pose.apply([self.seen_centre + error, 0.0, 0.0])
        pose = RigidTransform.from_components(centre, self.pose.rotation)
        solid = Superquadric(0.5 * np.array(self.pieces[0].size), (0.1, 0.1), pose, "box")
        return TabletopObject(OBJECT, solid, mass, COLOUR)


SHAPES = (
    ClosureShape("box", (Piece(0.0, (0.18, 0.045, 0.04)),)),
    ClosureShape("cylinder", (Piece(0.0, (0.17, 0.044, 0.044), round=True),)),
    ClosureShape(
        "bottle",
        (
            Piece(0.0, (0.13, 0.056, 0.056), round=True),
            Piece(0.1, (0.07, 0.026, 0.026), round=True),
        ),
    ),
    ClosureShape(
        "hammer",
        (Piece(0.0, (0.20, 0.026, 0.026)), Piece(0.113, (0.026, 0.07, 0.026))),
        (0.55, 0.45),
    ),
)
"""Shapes of the trials. The head of the hammer is steel, so that a camera misjudges the centre."""
