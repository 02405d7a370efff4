"""The superquadric: one formula for solids from spheres to cylinders and boxes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform
from scipy.special import beta

from eyehand.errors import InputError

from .radial_scale import log_radial_scale, straighten, taper_factors
from .support_kernels import tapered_supports

Kind = Literal["sphere", "cylinder", "ellipsoid", "box", "superquadric", "tapered"]
"""Kinds of solids, simplest first."""

PARAMETER_COUNT: dict[Kind, int] = {
    "sphere": 4,
    "cylinder": 7,
    "ellipsoid": 9,
    "box": 9,
    "superquadric": 11,
    "tapered": 13,
}
"""Number of free parameters of each kind."""

MIN_EXPONENT = 0.02
MAX_EXPONENT = 1.98
"""Limits of the exponents. At 0 and 2 the solid is a polyhedron, whose normals jump."""

MAX_TAPER = 0.9
"""Limit of the taper: a section keeps at least a tenth of the size of the middle. At 1 the solid
would end in a point."""
KIND_TOLERANCE = 1e-6
"""Maximum relative difference of numbers that a kind requires to be equal: round-off, and digits
that text files lose."""
_TINY = 1e-12


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class Superquadric:
    """The solid ``((x/a1)^(2/ε2) + (y/a2)^(2/ε2))^(ε2/ε1) + (z/a3)^(2/ε1) <= 1``.

    All functions use the radial scale ``G = F^(ε1/2)``, which is homogeneous of degree one, in
    logarithms, so that small exponents do not overflow (Barr 1981; Solina and Bajcsy 1990).
    A tapered solid is this one after ``x ← x (1 + k1 z/a3)``, ``y ← y (1 + k2 z/a3)``.

    Raises
    ------
    InputError
        If a semi-axis is not positive, an exponent lies outside
        [MIN_EXPONENT, MAX_EXPONENT], a taper outside ±MAX_TAPER or not 0 on a kind that has
        none, a value is not finite, or the numbers are not those of the kind.
    """

    semi_axes: NDArray[np.float64]
    """Half extents a1, a2, a3 along the local axes, (3,), m."""
    exponents: tuple[float, float]
    """(ε1, ε2): ε1 shapes along local z, ε2 in the local xy-plane; 1 is round, near 0 is square."""
    pose: RigidTransform
    """Maps local coordinates to the frame of the solid (camera or world)."""
    kind: Kind = "superquadric"
    """The simplest kind that describes the shape."""
    taper: tuple[float, float] = (0.0, 0.0)
    """(k1, k2): relative increase of the width along x and y from the middle to the upper end."""

    def __post_init__(self) -> None:
        semi_axes = np.array(self.semi_axes, dtype=np.float64)
        if semi_axes.shape != (3,) or not np.all(np.isfinite(semi_axes)) or semi_axes.min() <= 0:
            raise InputError(f"semi_axes must be 3 finite lengths > 0 m, got {semi_axes.tolist()}")
        exponents = (float(self.exponents[0]), float(self.exponents[1]))
        if not all(MIN_EXPONENT <= e <= MAX_EXPONENT for e in exponents):
            raise InputError(
                f"exponents must lie in [{MIN_EXPONENT}, {MAX_EXPONENT}], got {exponents}"
            )
        if self.kind not in get_args(Kind):
            raise InputError(f"kind must be one of {', '.join(get_args(Kind))}, got {self.kind!r}")
        taper = (float(self.taper[0]), float(self.taper[1]))
        if not all(abs(k) <= MAX_TAPER for k in taper):
            raise InputError(f"taper must lie in [-{MAX_TAPER}, {MAX_TAPER}], got {taper}")
        if any(taper) and self.kind != "tapered":
            raise InputError(f"taper must be (0, 0) unless kind is tapered, got {taper}")
        problem = _not_of_kind(self.kind, semi_axes, exponents)
        if problem:
            raise InputError(
                f"{problem}, got semi-axes {semi_axes.tolist()}, exponents {exponents}"
            )
        semi_axes.setflags(write=False)
        object.__setattr__(self, "taper", taper)
        object.__setattr__(self, "semi_axes", semi_axes)
        object.__setattr__(self, "exponents", exponents)

    @property
    def centre(self) -> NDArray[np.float64]:
        """Centre of the solid, (3,), m."""
        return np.asarray(self.pose.translation)

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Local axes as columns, (3, 3)."""
        # `pose.rotation` takes a hundred times as long, because it checks the matrix.
        return np.array(self.pose.as_matrix()[:3, :3])

    @property
    def parameter_count(self) -> int:
        """Number of free parameters of this kind of solid."""
        return PARAMETER_COUNT[self.kind]

    @property
    def volume(self) -> float:
        """Volume in m³, closed form by beta functions (Jaklič, Leonardis and Solina 2000)."""
        e1, e2 = self.exponents
        shape = 2.0 * e1 * e2 * beta(e1 / 2 + 1, e1) * beta(e2 / 2, e2 / 2)
        # The odd term of (1 + k1 t)(1 + k2 t) cancels. The mean of t² over the volume remains.
        mean_square = beta(1.5 * e1, e1 + 1) / beta(0.5 * e1, e1 + 1)
        widened = 1.0 + self.taper[0] * self.taper[1] * mean_square
        return float(np.prod(self.semi_axes) * shape * widened)

    def to_local(self, points: ArrayLike) -> NDArray[np.float64]:
        """Transform points (…, 3) from the frame of the solid to local coordinates."""
        return (np.asarray(points, dtype=np.float64) - self.centre) @ self.rotation

    def to_parent(self, local: ArrayLike) -> NDArray[np.float64]:
        """Transform points (…, 3) from local coordinates to the frame of the solid."""
        return np.asarray(local, dtype=np.float64) @ self.rotation.T + self.centre

    def radial_scale(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return G at points (…, 3), (…,): 1 on the surface, below 1 inside.

        Without taper the solid scaled by G about its centre touches the point.
        """
        return np.exp(self._log_radial_scale(points)[0])

    def implicit(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the inside-outside function F = G^(2/ε1) at points (…, 3), (…,)."""
        log_f = 2.0 / self.exponents[0] * self._log_radial_scale(points)[0]
        return np.exp(np.minimum(log_f, np.log(np.finfo(float).max)))

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether points (…, 3) lie inside or on the surface, (…,) bool."""
        return self.radial_scale(points) <= 1.0

    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the first-order distance (G-1)/‖∇G‖ (…,), m, negative inside (Sampson 1982).

        It is exact for a sphere. Elsewhere the error is of second order in the distance, so that
        it is meaningful near the surface only.
        """
        log_g, gradient = self._log_radial_scale(points)
        return -np.expm1(-log_g) / np.maximum(np.linalg.norm(gradient, axis=-1), _TINY)

    def normals(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return outward unit normals (…, 3) of the level sets of G through points (…, 3)."""
        _, gradient = self._log_radial_scale(points)
        length = np.linalg.norm(gradient, axis=-1, keepdims=True)
        return gradient / np.maximum(length, _TINY) @ self.rotation.T

    def support(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Return the largest ``d·x`` over the solid for directions d (…, 3), (…,), m.

        G is a norm of the offset from the centre. Its support function is the dual norm: a
        superquadric with exponents 2 - ε on inverse semi-axes. With taper it is the largest
        support of the sections of constant z, which have that closed form.
        """
        directions = np.asarray(directions, dtype=np.float64)
        local = directions @ self.rotation
        if any(self.taper):
            flat = np.ascontiguousarray(local.reshape(-1, 3))
            support = tapered_supports(flat, self.semi_axes, self.exponents, self.taper)
            support = support.reshape(local.shape[:-1])
        else:
            dual = (2.0 - self.exponents[0], 2.0 - self.exponents[1])
            support = np.exp(log_radial_scale(local, 1.0 / self.semi_axes, dual)[0])
        return support + directions @ self.centre

    def project_radially(self, points: ArrayLike) -> NDArray[np.float64]:
        """Project points (…, 3) onto the surface along the ray from the centre, (…, 3).

        With taper the projection follows the tapered image of the ray.
        """
        straight, _ = straighten(self.to_local(points), self.semi_axes[2], self.taper)
        log_g, _ = log_radial_scale(straight, self.semi_axes, self.exponents)
        return self.to_parent(self.apply_taper(straight * np.exp(-log_g)[..., None]))

    def apply_taper(self, straight: NDArray[np.float64]) -> NDArray[np.float64]:
        """Apply the taper to local coordinates (…, 3) of the straight solid, (…, 3)."""
        if not any(self.taper):
            return straight
        factors = taper_factors(straight[..., 2], self.semi_axes[2], self.taper)
        return straight * np.concatenate([factors, np.ones_like(factors[..., :1])], axis=-1)

    def _log_radial_scale(
        self, points: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return log G (…,) and its gradient (…, 3) in local axes."""
        straight, pull_back = straighten(self.to_local(points), self.semi_axes[2], self.taper)
        log_g, gradient = log_radial_scale(straight, self.semi_axes, self.exponents)
        return log_g, pull_back(gradient)


def _not_of_kind(kind: Kind, semi_axes: NDArray[np.float64], exponents: tuple[float, float]) -> str:
    """Return why numbers are not those of a kind, or an empty string."""
    e1, e2 = exponents
    if kind == "sphere" and not (_equal(*semi_axes) and _equal(e1, e2, 1.0)):
        return "a sphere has equal semi-axes and exponents (1, 1)"
    if kind == "ellipsoid" and not _equal(e1, e2, 1.0):
        return "an ellipsoid has exponents (1, 1)"
    if kind == "cylinder" and not (_equal(*semi_axes[:2]) and _equal(e2, 1.0)):
        return "a cylinder has a1 = a2 and ε2 = 1"
    if kind == "box" and not _equal(e1, e2):
        return "a box has equal exponents"
    return ""


def _equal(*values: float) -> bool:
    return max(values) - min(values) <= KIND_TOLERANCE * max(values)
