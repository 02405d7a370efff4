"""Named tuples of arrays that the compiled contact kernels take."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from numpy.typing import NDArray


class PadPose(NamedTuple):
    """The pad's frame in the world."""

    position: NDArray
    """(3,) float64, m."""
    rotation: NDArray
    """(9,) float64, row by row."""


class SimpleSolids(NamedTuple):
    """K geoms whose surface has a closed form."""

    positions: NDArray
    """(K, 3) float64, origins in the world, m."""
    rotations: NDArray
    """(K, 9) float64, world from solid, row by row."""
    kinds: NDArray
    """(K,) int32, kind of geom (see :mod:`column_entry`)."""
    sizes: NDArray
    """(K, 3) float64, sizes as MuJoCo has them, m."""
    radii: NDArray
    """(K,) float64, bounding radii, m."""
    laws: NDArray
    """(K,) int32, row of the pressure tables that holds for each solid."""
    samples: NDArray
    """(K,) int32, rows of samples over each solid, and samples in a row."""
    masses: NDArray
    """(K,) float64, mass of the body of each solid, kg; inf if it cannot move."""


class MeshSolid(NamedTuple):
    """A triangle mesh."""

    position: NDArray
    """(3,) float64, origin in the world, m."""
    rotation: NDArray
    """(9,) float64, world from mesh, row by row."""
    radius: float
    """Bounding radius about the origin, m."""
    vertices: NDArray
    """(V, 3) float64 in the mesh's frame, m."""
    faces: NDArray
    """(T, 3) int32."""
    mass: float
    """Mass of its body, kg; inf if it cannot move."""
    buffer: NDArray
    """(V, 3) float64, overwritten by the vertices in the pad's frame."""


class PressureTables(NamedTuple):
    """Pressure over depth for L pairs of foams (see :class:`foam.PressureTable`)."""

    pressures: NDArray
    """(L, T) float64, Pa."""
    steps: NDArray
    """(L,) float64, depth between two entries, m."""


class ContactState(NamedTuple):
    """State of K solids that one call passes to the next; kernels overwrite it."""

    poses: NDArray
    """(K, POSE_FIELDS) float64, poses in the pad's frame (see :mod:`contact_motion`)."""
    wrenches: NDArray
    """(K, 6) float64, force (N) and torque about the pad's origin (N m) on each solid, in the
    pad's frame. The last wrench limits friction."""
    stiffness: NDArray
    """(K,) float64, the bed's normal stiffness under each solid, N/m. The last value limits
    damping."""


class ColumnLaw(NamedTuple):
    """The reaction of a foam column to one moving solid."""

    table: NDArray
    """(T,) float64, pressure over depth, Pa."""
    step: float
    """Depth between two entries of the table, m."""
    loss_time: float
    """Damping over stiffness, s."""
    slip: float
    """Speed at which friction has grown to 1/√2 of its full value, m/s."""
    lead: float
    """Time by which bent bristles are advanced, s (see :func:`bristles.bristle_force`)."""
    twist: NDArray
    """(6,) float64, velocity of the solid at the pad's origin, m/s, and angular velocity, rad/s,
    in the pad's frame."""
