"""Objects to touch, assembled from simple solids, rigid or of foam.

The frame of each object has z up. Its origin is the point that a pad coming from above touches
first, unless the object states otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from eyehand.errors import InputError

from ..mujoco_import import import_mujoco
from .foam import Foam

Kind = Literal["sphere", "capsule", "ellipsoid", "cylinder", "box"]


STIFF_FOAM = Foam(thickness=0.03, modulus=150e3, densification=0.7)
"""Foam of toy boxes, as packing foam: 5 MPa/m, in series with the pad's 3 MPa/m."""
BALL_FOAM = Foam(thickness=0.035, modulus=12e3, densification=0.8)
"""Foam of a soft ball, one radius thick: 0.34 MPa/m, ten times as soft as the pad."""
OBJECT_COLOUR = (0.72, 0.42, 0.2, 1.0)
"""Colour of all objects, RGBA."""
PEN_RADIUS = 0.004
"""Radius of the rounded end of a pen, m."""
PROBE_RADIUS = 0.001
"""Radius of the probe tip, m: 2 mm in diameter, as in the chapter's Fig. 5."""


@dataclass(frozen=True)
class Part:
    """One solid of an object.

    Raises
    ------
    InputError
        If a size is not positive.
    """

    kind: Kind
    """Kind of geom, named as in MuJoCo."""
    size: tuple[float, ...]
    """Sizes as in MuJoCo, m: radius; radius and half length along z; semi-axes; half edges."""
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position of its centre in the object's frame, m."""
    quat_wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Rotation, object from part."""

    def __post_init__(self) -> None:
        if not all(0 < value < np.inf for value in self.size):
            raise InputError(f"sizes of a {self.kind} must be > 0 m, got {self.size}")


@dataclass(frozen=True)
class TouchObject:
    """An object to touch."""

    name: str
    """Name; geoms have this name and their number."""
    parts: tuple[Part, ...]
    """Solids of the object."""
    foam: Foam | None = None
    """Material, as a layer of foam; None for a rigid object."""

    def add_geoms(self, body: Any, mass: float, contact_bits: int) -> dict[str, Foam]:
        """Add the parts to a body of an `MjSpec`, and return the foam of each geom, by name.

        Parameters
        ----------
        body
            Body whose frame is the object's frame.
        mass
            Mass of the object, kg, divided evenly between the parts.
        contact_bits
            Both of MuJoCo's contact masks, `contype` and `conaffinity`.
        """
        kinds = import_mujoco().mjtGeom
        names = [f"{self.name}_{number}" for number in range(len(self.parts))]
        for name, part in zip(names, self.parts, strict=True):
            geom = body.add_geom(name=name, type=getattr(kinds, f"mjGEOM_{part.kind.upper()}"))
            geom.size[: len(part.size)] = part.size
            geom.pos, geom.quat = part.place, part.quat_wxyz
            geom.contype = geom.conaffinity = contact_bits
            geom.mass, geom.rgba = mass / len(self.parts), OBJECT_COLOUR
        return dict.fromkeys(names, self.foam) if self.foam else {}


def pen() -> TouchObject:
    """Return the rounded end of an upright, rigid pen."""
    half = 0.06
    return TouchObject(
        "pen", (Part("capsule", (PEN_RADIUS, half), (0.0, 0.0, -half - PEN_RADIUS)),)
    )


def toy_box() -> TouchObject:
    """Return a toy box of stiff foam, 40 x 30 x 40 mm, with its flat top up."""
    return TouchObject(
        "toy_box", (Part("box", (0.02, 0.015, 0.02), (0.0, 0.0, -0.02)),), STIFF_FOAM
    )


def soft_ball() -> TouchObject:
    """Return a soft ball, 70 mm in diameter."""
    radius = BALL_FOAM.thickness
    return TouchObject("soft_ball", (Part("sphere", (radius,), (0.0, 0.0, -radius)),), BALL_FOAM)


def probe() -> TouchObject:
    """Return an upright, flat-ended rigid pin, 2 mm in diameter."""
    half = 0.02
    return TouchObject("probe", (Part("cylinder", (PROBE_RADIUS, half), (0.0, 0.0, -half)),))


def box_edge(length: float = 0.16, side: float = 0.04) -> TouchObject:
    """Return a rigid box with an edge up, along x.

    Parameters
    ----------
    length
        Length of the edge, m.
    side
        Side of the square cross-section, m.
    """
    low = side / np.sqrt(2)
    size = (0.5 * length, 0.5 * side, 0.5 * side)
    return TouchObject(
        "box_edge", (Part("box", size, (0.0, 0.0, -low), _quat([np.pi / 4, 0.0, 0.0])),)
    )


def tilted_face(tilt: float, direction: float = 0.0, side: float = 0.06) -> TouchObject:
    """Return a tilted, flat, rigid face, onto which a pad can roll.

    Parameters
    ----------
    tilt
        Angle between the face's normal and z, rad.
    direction
        Azimuth of the normal, about z from x, rad.
    side
        Side of the square face, m. The origin is its middle.
    """
    axis = np.array([-np.sin(direction), np.cos(direction), 0.0])
    turn = Rotation.from_rotvec(tilt * axis)
    half = 0.5 * side
    low = turn.apply([0.0, 0.0, -half])
    part = Part("box", (half, half, half), _tuple(low), _quat(tilt * axis))
    return TouchObject("tilted_face", (part,))


def cable(centre_line: ArrayLike, radius: float) -> TouchObject:
    """Return a cable as a chain of capsules.

    Parameters
    ----------
    centre_line
        Points (M, 3) of the centre line in the object's frame, m, M >= 2. In bends they should be
        closer than the cable's diameter.
    radius
        Radius of the cable, m.

    Raises
    ------
    InputError
        If there are fewer than two points, two that follow are the same, or one is not finite.
    """
    points = np.asarray(centre_line, float)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise InputError(f"a centre line must be (M, 3) with M >= 2, got {points.shape}")
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    if not (np.isfinite(points).all() and (lengths > 0).all()):
        raise InputError("points of a centre line must be finite and differ from the next")
    parts = [
        Part(
            "capsule",
            (radius, 0.5 * float(length)),
            _tuple(middle),
            _quat_from_z(step / length),
        )
        for middle, step, length in zip(
            0.5 * (points[1:] + points[:-1]), steps, lengths, strict=True
        )
    ]
    return TouchObject("cable", tuple(parts))


def unknown_object(seed: int = 0) -> TouchObject:
    """Return a rigid object of unknown shape to explore, about 200 x 140 mm.

    There are three kinds: a flat dome with a ridge and a block; a smooth pebble of three round
    bodies; a lying barrel with rims, a disc and a ridge across. The origin is the top of the
    largest part; the other parts protrude by 2-5 mm.

    Parameters
    ----------
    seed
        The seed modulo 3 selects the kind. From seed 3 on, the protruding parts are also moved,
        rotated and resized at random.

    Raises
    ------
    InputError
        If the seed is negative.
    """
    if seed < 0:
        raise InputError(f"an unknown object's seed must be >= 0, got {seed}")
    kinds = (_dome, _pebble, _barrel)
    rng = np.random.default_rng(seed)
    change = rng.uniform(-1.0, 1.0, 6) if seed >= len(kinds) else np.zeros(6)
    return TouchObject("unknown", kinds[seed % len(kinds)](change))


def _dome(change: NDArray[np.float64]) -> tuple[Part, ...]:
    turn = np.arctan2(0.6, 0.8) + 0.4 * change[0]
    ridge = [np.cos(turn), np.sin(turn), 0.0]
    size = 1.0 + 0.15 * change[1]
    return (
        Part("ellipsoid", (0.1, 0.07, 0.03), (0.0, 0.0, -0.03)),
        Part(
            "capsule",
            (0.012, 0.035),
            (-0.04 + 0.006 * change[2], 0.01 + 0.006 * change[3], -0.0118),
            _quat_from_z(ridge),
        ),
        Part(
            "box",
            (0.022 * size, 0.018 * size, 0.014),
            (0.045 + 0.005 * change[4], -0.012, -0.0127),
            _quat([0.0, 0.0, 0.5 + 0.4 * change[5]]),
        ),
    )


def _pebble(change: NDArray[np.float64]) -> tuple[Part, ...]:
    return (
        Part("ellipsoid", (0.1, 0.07, 0.03), (0.0, 0.0, -0.03)),
        Part(
            "ellipsoid",
            (0.05, 0.035 + 0.004 * change[0], 0.018),
            (0.045 + 0.006 * change[1], 0.012 + 0.008 * change[2], -0.0165),
            _quat([0.0, 0.0, 0.6 + 0.4 * change[3]]),
        ),
        Part(
            "ellipsoid",
            (0.04, 0.04, 0.028),
            (-0.045 + 0.006 * change[4], -0.015 + 0.008 * change[5], -0.0275),
        ),
    )


def _barrel(change: NDArray[np.float64]) -> tuple[Part, ...]:
    lying = _quat([0.0, np.pi / 2, 0.0])
    turn = np.pi / 2 + 0.4 * change[0]
    return (
        Part("cylinder", (0.09, 0.085), (0.0, 0.0, -0.09), lying),
        Part(
            "cylinder",
            (0.02 + 0.003 * change[1], 0.014),
            (0.045 + 0.006 * change[2], -0.01 + 0.006 * change[3], -0.012),
        ),
        Part(
            "capsule",
            (0.01, 0.025),
            (-0.045 + 0.006 * change[4], 0.004 * change[5], -0.008),
            _quat_from_z([np.cos(turn), np.sin(turn), 0.0]),
        ),
    )


def _tuple(place: ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(place, float).tolist()
    return x, y, z


def _quat(rotation_vector: ArrayLike) -> tuple[float, float, float, float]:
    w, x, y, z = Rotation.from_rotvec(rotation_vector).as_quat(scalar_first=True).tolist()
    return w, x, y, z


def _quat_from_z(direction: ArrayLike) -> tuple[float, float, float, float]:
    """Return the rotation from z to a direction of any length, w, x, y, z."""
    d = np.asarray(direction, float)
    x, y, z = d / np.linalg.norm(d)
    angle = np.arctan2(np.hypot(x, y), z)
    across = np.array([-y, x, 0.0])
    norm = np.linalg.norm(across)
    # Straight up or down, any horizontal axis is right.
    axis = across / norm if norm > 0 else np.array([1.0, 0.0, 0.0])
    return _quat(angle * axis)
