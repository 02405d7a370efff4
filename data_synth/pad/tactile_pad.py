"""A simulated tactile pad: an elastic foam bed that is itself the contact, and what it feels."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError
from eyehand.tactile import TactileArray

from .body_forces import push_bodies
from .column_entry import BOX, CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from .contact_motion import POSE_FIELDS
from .foam import Foam, pressure_table
from .foam_column import FINE
from .mesh_contact import press_mesh
from .solid_contact import press_bed
from .tactel_spread import spread_to_tactels, spread_weights
from .tactile_readout import TactileReadout

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

IMAGE_RATE = 1900.0
"""Images a second of the pad that is simulated (Schürmann et al., IROS 2011)."""
PAD_SITE = "pad"
"""Name of the site in the middle of the foam's surface; its z-axis points towards the object."""

MESH_SAMPLES = 32
"""Columns each way that a mesh's sunken part is drawn on: its border is known to one of them, as
its rows are not searched."""

_MESH = 7
_KINDS = (SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX)


@dataclass(frozen=True)
class PadOptions:
    """What the pad is made of, and how finely its contact is sampled.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    rows: int = 16
    """Tactels along y."""
    columns: int = 16
    """Tactels along x."""
    pitch: float = 0.005
    """Between the centres of two tactels, m."""
    foam: Foam = field(default_factory=Foam)
    """The layer of foam that covers the tactels."""
    spread: float = 0.0025
    """Standard deviation of the Gaussian that a point force is felt as, m: half the pitch lets two
    to three tactels share it. Narrower, and a probe's place between tactels is lost."""
    loss_time: float = 0.002
    """Damping over stiffness of the foam, s: its loss factor at f Hz is 2π f times this, 0.13 at
    10 Hz, as soft polyurethane foams have. Longer calms light objects and adds to the pressure
    while a surface sinks."""
    friction: float = 0.6
    """Coulomb's coefficient between foam and objects."""
    slip_speed: float = 0.005
    """Speed at which friction has grown to 1/√2 of its full value, m/s: lower holds better and
    needs shorter steps."""
    sample_spacing: float = 0.0015
    """Rows of samples over an object: its diameter over this, m, within the two bounds below."""
    fewest_samples: int = 8
    """Rows on the smallest object; each has as many samples as there are rows."""
    most_samples: int = 24
    """Rows on the largest: cost grows with the square."""

    def __post_init__(self) -> None:
        lengths = (self.pitch, self.spread, self.slip_speed, self.sample_spacing)
        if self.rows < 1 or self.columns < 1 or not all(0 < x < np.inf for x in lengths):
            raise InputError(
                "rows, columns, pitch, spread, slip_speed and sample_spacing must be > 0, got "
                f"{self.rows}, {self.columns}, {lengths}"
            )
        if not (0 <= self.loss_time < np.inf and 0 <= self.friction < np.inf):
            raise InputError(
                f"loss_time and friction must be >= 0, got {self.loss_time} s, {self.friction}"
            )
        if not 2 <= self.fewest_samples <= self.most_samples:
            raise InputError(
                "samples must be 2 <= fewest <= most, got "
                f"{self.fewest_samples}, {self.most_samples}"
            )


class TactilePad:
    """A foam pad at a site of a MuJoCo model.

    Every geom is felt that collides, is a sphere, capsule, ellipsoid, cylinder, box or mesh, and is
    not part of the pad's own mechanism. Planes and height fields are not. The bed is the contact:
    the model itself should let the pad collide only where its foam is solid (see
    :mod:`pad_scene`).

    Parameters
    ----------
    model, data
        ``mujoco.MjModel`` and ``mujoco.MjData``; the pad keeps views of the data's arrays.
    site
        Name of the site in the middle of the foam's free surface, z outwards.
    options
        The pad.
    softness
        Name of a geom → what it is made of, as a layer of foam; others are rigid.
    readout
        The electronics; the default ones when not given.

    Raises
    ------
    InputError
        If the model has no such site or geom, or the read-out has another number of tactels.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        site: str = PAD_SITE,
        options: PadOptions | None = None,
        softness: Mapping[str, Foam] | None = None,
        readout: TactileReadout | None = None,
    ) -> None:
        self.options = options or PadOptions()
        o = self.options
        self.array = TactileArray.flat(o.rows, o.columns, o.pitch)
        count = o.rows * o.columns
        self.readout = readout or TactileReadout.draw(count)
        if self.readout.tactels != count:
            raise InputError(f"the pad has {count} tactels, its readout {self.readout.tactels}")
        number = _named(model.nsite, model.site, site, "site")
        self._place, self._rotation = data.site_xpos[number], data.site_xmat[number]
        self._body = int(model.site_bodyid[number])
        self._data = data
        self._last_time = np.inf
        self._choose_geoms(model, self._body)
        self._choose_laws(model, softness or {})
        self._across = spread_weights(o.columns, o.pitch, o.spread)
        self._down = spread_weights(o.rows, o.pitch, o.spread)
        self._bed = np.array(
            [
                0.5 * o.columns * o.pitch,
                0.5 * o.rows * o.pitch,
                o.foam.thickness,
                o.loss_time,
                o.friction,
                o.slip_speed,
            ]
        )
        solids = len(self._geoms)
        self._before = np.zeros((solids, POSE_FIELDS))
        self._wrenches = np.zeros((solids, 6))
        self._stiffness = np.zeros(solids)
        self._fine = np.zeros((3, FINE * o.rows, FINE * o.columns))
        self._depths = np.zeros((MESH_SAMPLES, MESH_SAMPLES))
        self._pushed = np.zeros((model.nbody, 6))
        self.true_pressures: NDArray[np.float64] = np.zeros(count)
        """(N,), Pa: what each tactel bears, before the electronics. The next contact overwrites
        it, as it does the other arrays here."""
        self.true_shear: NDArray[np.float64] = np.zeros((count, 2))
        """(N, 2), Pa: what objects drag the foam with, along the pad's x and y."""
        self.wrench: NDArray[np.float64] = np.zeros(6)
        """Force, N, and torque about the pad's origin, N m, of the foam on all objects, (6,), in
        the pad's frame."""

    @property
    def force(self) -> float:
        """Normal force on the pad, N, >= 0: the sum of the image."""
        return float(self.wrench[2])

    @property
    def centre(self) -> NDArray[np.float64]:
        """True centre of pressure in the pad's frame, (3,), m; NaN when nothing touches.

        What presses within a fine cell of the border counts as pressing in its middle, at most.
        """
        fz = self.wrench[2]
        if not fz > 0.0:
            return np.full(3, np.nan)
        bx, by = self._bed[:2]
        # The torque of the normal forces alone: friction's arm is the depth, which is not here.
        image = self._fine[0]
        x = (np.arange(image.shape[1]) + 0.5) * (2 * bx / image.shape[1]) - bx
        y = (np.arange(image.shape[0]) + 0.5) * (2 * by / image.shape[0]) - by
        return np.array([image.sum(axis=0) @ x, image.sum(axis=1) @ y, 0.0]) / fz

    @property
    def pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Place (3,), m, and rotation (3, 3) of the pad's frame in the world's, as of now."""
        return self._place.copy(), self._rotation.reshape(3, 3).copy()

    def contact(self) -> int:
        """Press what is near into the foam, and let the foam push back on the bodies.

        To be called once a step, when ``data`` holds the poses of the moment (after
        ``mj_kinematics`` or ``mj_step1``) and before forces are used (``mj_step2``). Rates come
        from the poses of the call before, over the difference of ``data.time``; a call at the
        same time or an earlier one starts anew. Forces are added to ``data.xfrc_applied``, and
        those of the call before taken out.

        Returns
        -------
        int
            How many geoms touch.
        """
        data = self._data
        dt = max(data.time - self._last_time, 0.0)
        if dt == 0.0:
            self._before[:, -1] = 0.0
        self._last_time = data.time
        places, rotations = self._places[self._geoms], self._rotations[self._geoms]
        simple = self._simple
        touching = press_bed(
            self._place,
            self._rotation,
            places[:simple],
            rotations[:simple],
            self._kinds[:simple],
            self._sizes[:simple],
            self._radii[:simple],
            self._laws[:simple],
            self._samples[:simple],
            self._masses[:simple],
            self._tables,
            self._steps,
            self._bed,
            dt,
            self._before[:simple],
            self._wrenches[:simple],
            self._stiffness[:simple],
            self._fine,
        )
        for k, (vertices, faces, room) in enumerate(self._meshes, start=simple):
            law = self._laws[k]
            touching += press_mesh(
                self._place,
                self._rotation,
                places[k],
                rotations[k],
                self._radii[k],
                vertices,
                faces,
                self._masses[k],
                self._tables[law],
                self._steps[law],
                self._bed,
                dt,
                self._before[k],
                self._wrenches[k],
                self._stiffness[k : k + 1],
                room,
                self._depths,
                self._fine,
            )
        push_bodies(
            self._place,
            self._rotation,
            self._wrenches,
            self._bodies,
            self._body,
            data.xipos,
            self._pushed,
            data.xfrc_applied,
            self.wrench,
        )
        spread_to_tactels(
            self._fine,
            self._across,
            self._down,
            self.array.area,
            self.true_pressures,
            self.true_shear,
        )
        return touching

    def read(self, rng: np.random.Generator) -> NDArray[np.uint16]:
        """Read the image of the last contact through the electronics.

        Parameters
        ----------
        rng
            Source of the noise.

        Returns
        -------
        NDArray
            (N,) uint16, 12 bits, row by row as ``array`` has the tactels.
        """
        return self.readout.raw(self.true_pressures, rng)

    def quickest(self) -> float:
        """Give the highest angular frequency of a free body on the bed, rad/s; 0 if none touches.

        A step much longer than its inverse lets the body chatter.
        """
        if self._stiffness.size == 0:
            return 0.0
        return float(np.sqrt(np.max(self._stiffness / self._masses)))

    def _choose_geoms(self, model: Any, body: int) -> None:
        root = model.body_rootid[body]
        geom_body = model.geom_bodyid
        own = model.body_rootid[geom_body] == root if root else geom_body == body
        solid = ~own & ((model.geom_contype | model.geom_conaffinity) != 0)
        simple = np.flatnonzero(solid & np.isin(model.geom_type, _KINDS))
        meshes = np.flatnonzero(solid & (model.geom_type == _MESH))
        self._geoms = np.concatenate([simple, meshes])
        self._simple = len(simple)
        self._meshes = [_mesh(model, int(geom)) for geom in meshes]
        self._kinds = model.geom_type[self._geoms].astype(np.int32)
        self._sizes = model.geom_size[self._geoms].copy()
        self._radii = model.geom_rbound[self._geoms].copy()
        self._bodies = geom_body[self._geoms].astype(np.int64)
        weld = model.body_weldid[self._bodies]
        self._masses = np.where(weld == 0, np.inf, model.body_subtreemass[weld])
        self._places, self._rotations = self._data.geom_xpos, self._data.geom_xmat
        o = self.options
        rows = np.ceil(2 * self._radii / o.sample_spacing)
        self._samples = np.clip(rows, o.fewest_samples, o.most_samples).astype(np.int32)

    def _choose_laws(self, model: Any, softness: Mapping[str, Foam]) -> None:
        kinds: list[Foam | None] = [None, *dict.fromkeys(softness.values())]
        tables = [pressure_table(self.options.foam, kind) for kind in kinds]
        self._tables = np.array([table.pressures for table in tables])
        self._steps = np.array([table.step for table in tables])
        law = np.zeros(model.ngeom, np.int32)
        for name, foam in softness.items():
            law[_named(model.ngeom, model.geom, name, "geom")] = kinds.index(foam)
        self._laws = law[self._geoms]


def _mesh(model: Any, geom: int) -> tuple[NDArray[Any], NDArray[Any], NDArray[np.float64]]:
    """Vertices, faces, and room for the vertices in the pad's frame."""
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    vertices = model.mesh_vert[first : first + count].astype(float)
    return vertices, model.mesh_face[face : face + faces].astype(np.int32), np.empty((count, 3))


def _named(count: int, look_up: Any, name: str, what: str) -> int:
    for number in range(count):
        if look_up(number).name == name:
            return number
    raise InputError(f"the model has no {what} named {name!r}")
