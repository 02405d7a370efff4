"""A simulated tactile pad: an elastic foam bed that is the contact itself, and its readings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.tactile import TactileArray

from .body_forces import push_bodies
from .bristles import BRISTLE_FIELDS, bend_bristles
from .column_entry import BOX, CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from .contact_data import ContactState, MeshSolid, PadPose, PressureTables, SimpleSolids
from .contact_motion import POSE_FIELDS
from .foam import Foam, PadOptions, pressure_table
from .foam_column import CELLS_PER_TACTEL
from .layer_shear import base_forces
from .mesh_contact import press_mesh
from .sensor_memory import SensorMemory
from .sensor_model import SENSORS, SensorModel
from .solid_contact import press_solids
from .tactel_spread import POINT_SPREAD_M, spread_to_tactels, spread_weights
from .tactile_readout import TactileReadout

IMAGE_RATE = 1900.0
"""Images per second of the simulated pad (Schürmann et al., IROS 2011)."""
PAD_SITE = "pad"
"""Name of the site in the middle of the foam's surface; its z-axis points towards the object."""

_MESH_SAMPLES = 32
"""Columns each way over the sunken part of a mesh. The border of a mesh is exact to one column,
because its rows are not searched."""
LOSS_TIME_S = 0.002
"""Damping over stiffness of the foam. Its loss factor at f Hz is 2π f times this: 0.13 at 10 Hz, as
of soft polyurethane foams. A longer time calms light objects, and raises the pressure while a
surface sinks."""
_SLIP_SPEED_M_S = 0.005
"""Speed at which friction has grown to 1/√2 of its full value. A lower speed holds better and
needs shorter steps."""
SHEAR_SHARE = 0.5
"""Shear modulus of the foam over its modulus in compression. Poisson's ratio of soft open-cell
foams is close to 0, which makes it 1/2."""
_SAMPLE_SPACING_M = 0.0015
"""Rows of samples over an object: its diameter over this length, within the two bounds below."""
_MIN_SAMPLES = 8
"""Rows over the smallest object; each row has as many samples as there are rows."""
_MAX_SAMPLES = 24
"""Rows over the largest object; the cost grows with their square."""

_MESH = 7
_KINDS = (SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX)


class TactilePad:
    """A foam pad at a site of a MuJoCo model.

    The pad feels every geom that collides, is a sphere, capsule, ellipsoid, cylinder, box or mesh,
    and is not part of the pad's own mechanism. It does not feel planes and height fields. The bed
    is the contact: in the model itself, the pad should collide only where its foam is solid (see
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
        Foam of each geom by name; other geoms are rigid.
    readout
        The electronics; those of seed 0 of the sensor model if not given.
    sensor
        The sensor model; "good" of :data:`SENSORS` if not given.
    seed
        Source of the tactels' gains and drifts, >= 0.

    Raises
    ------
    InputError
        If the model has no such site or geom, or the readout has another number of tactels.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        site: str = PAD_SITE,
        options: PadOptions | None = None,
        softness: Mapping[str, Foam] | None = None,
        readout: TactileReadout | None = None,
        sensor: SensorModel | None = None,
        seed: int = 0,
    ) -> None:
        self.options = options or PadOptions()
        o = self.options
        self.array = TactileArray.flat(o.rows, o.columns, o.pitch)
        count = o.rows * o.columns
        self.sensor = sensor or SENSORS["good"]
        self.readout = readout or self.sensor.readout(count)
        if self.readout.tactels != count:
            raise InputError(f"the pad has {count} tactels, its readout {self.readout.tactels}")
        self._memory = SensorMemory(self.sensor, self.readout, seed)
        number = _index_of(model.nsite, model.site, site, "site")
        self._pad = PadPose(data.site_xpos[number], data.site_xmat[number])
        self._body = int(model.site_bodyid[number])
        self._data = data
        self._last_time = np.inf
        self._across = spread_weights(o.columns, o.pitch, POINT_SPREAD_M)
        self._down = spread_weights(o.rows, o.pitch, POINT_SPREAD_M)
        half_x, half_y = 0.5 * o.columns * o.pitch, 0.5 * o.rows * o.pitch
        foam = o.foam
        shear_stiffness = (
            SHEAR_SHARE * foam.modulus / foam.thickness if self.sensor.shear > 0 else 0.0
        )
        self._bed = np.array(
            [
                half_x, half_y, foam.thickness, LOSS_TIME_S, o.friction, _SLIP_SPEED_M_S,
                shear_stiffness,
            ]
        )  # fmt: skip
        self._select_geoms(model, softness or {})
        self._grid = np.zeros((3, CELLS_PER_TACTEL * o.rows, CELLS_PER_TACTEL * o.columns))
        self._base = np.zeros_like(self._grid)
        self._bristles = np.zeros((BRISTLE_FIELDS, *self._grid.shape[1:]))
        self._mesh_work = (np.zeros((_MESH_SAMPLES, _MESH_SAMPLES)), self._grid, self._bristles)
        self._pushed = np.zeros((model.nbody, 6))
        self.true_pressures: NDArray[np.float64] = np.zeros(count)
        """(N,), Pa: pressure on each tactel, before the electronics. It is negative where a sheared
        layer pulls. The next contact overwrites this array and the two below."""
        self.true_shear: NDArray[np.float64] = np.zeros((count, 2))
        """(N, 2), Pa: shear stress by friction, along the pad's x and y."""
        self.wrench: NDArray[np.float64] = np.zeros(6)
        """Force, N, and torque about the pad's origin, N m, of the foam on all objects, (6,), in
        the pad's frame."""
        self.slip_share = 0.0
        """Share of the normal force on columns that slide, 0..1; always 0 without shear."""

    @property
    def force(self) -> float:
        """Normal force on the pad, N, >= 0: the sum of the image."""
        return float(self.wrench[2])

    @property
    def centre(self) -> NDArray[np.float64]:
        """True centre of pressure in the pad's frame, (3,), m; NaN if nothing touches.

        Pressure within a grid cell of the border counts as pressure in the middle of the cell.
        """
        fz = self.wrench[2]
        if not fz > 0.0:
            return np.full(3, np.nan)
        bx, by = self._bed[:2]
        # The torque of the normal forces alone: that of friction has the depth as its arm.
        image = self._grid[0]
        x = (np.arange(image.shape[1]) + 0.5) * (2 * bx / image.shape[1]) - bx
        y = (np.arange(image.shape[0]) + 0.5) * (2 * by / image.shape[0]) - by
        return np.array([image.sum(axis=0) @ x, image.sum(axis=1) @ y, 0.0]) / fz

    @property
    def pose(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Current position (3,), m, and rotation (3, 3) of the pad's frame in the world."""
        return self._pad.position.copy(), self._pad.rotation.reshape(3, 3).copy()

    def contact(self) -> int:
        """Press nearby geoms into the foam, and apply the foam's forces to the bodies.

        Call this once per step, when ``data`` holds the current poses (after ``mj_kinematics`` or
        ``mj_step1``) and before forces are used (``mj_step2``). Velocities come from the poses of
        the last call and the difference of ``data.time``. A call at the same or an earlier time
        starts anew. Forces are added to ``data.xfrc_applied``, and those of the last call removed.

        Returns
        -------
        int
            Number of geoms that touch.
        """
        data, state = self._data, self._state
        dt = max(data.time - self._last_time, 0.0)
        if dt == 0.0:
            state.poses[:, -1] = 0.0
        self._last_time = data.time
        solids = self._solids
        simple = len(solids.kinds)
        solids.positions[:] = data.geom_xpos[self._geoms[:simple]]
        solids.rotations[:] = data.geom_xmat[self._geoms[:simple]]
        touching = press_solids(
            self._pad,
            solids,
            self._tables,
            self._bed,
            dt,
            self._solid_state,
            self._grid,
            self._bristles,
        )
        for k, mesh in enumerate(self._meshes, start=simple):
            law, geom = self._laws[k], self._geoms[k]
            touching += press_mesh(
                self._pad,
                mesh._replace(position=data.geom_xpos[geom], rotation=data.geom_xmat[geom]),
                self._tables.pressures[law],
                self._tables.steps[law],
                self._bed,
                dt,
                _rows(state, slice(k, k + 1)),
                self._mesh_work,
            )
        push_bodies(
            self._pad,
            state.wrenches,
            self._bodies,
            self._body,
            data.xipos,
            self._pushed,
            data.xfrc_applied,
            self.wrench,
        )
        image = self._grid
        if self.sensor.shear > 0:
            self.slip_share = bend_bristles(image, self._bed, dt, self._bristles)
            cell = self.options.pitch / CELLS_PER_TACTEL
            lever = self.sensor.shear * self.options.foam.thickness
            base_forces(image, lever, cell, cell, self._base)
            image = self._base
        area = self.array.area
        spread_to_tactels(
            image, self._across, self._down, area, self.true_pressures, self.true_shear
        )
        return touching

    def read(self, rng: np.random.Generator) -> NDArray[np.uint16]:
        """Read the image of the last contact through the electronics.

        Call this once per image: the sensor's memory advances to ``data.time``.

        Parameters
        ----------
        rng
            Source of the noise.

        Returns
        -------
        NDArray
            (N,) uint16, 12 bits, row by row as in ``array``. It is older by the sensor's wait.
        """
        return self._memory.read(float(self._data.time), self.true_pressures, rng)

    def max_frequency(self) -> float:
        """Return the highest angular frequency of a free body on the bed, rad/s; 0 if none touches.

        A time step much longer than its inverse makes the body oscillate.
        """
        if self._state.stiffness.size == 0:
            return 0.0
        return float(np.sqrt(np.max(self._state.stiffness / self._masses)))

    def _select_geoms(self, model: Any, softness: Mapping[str, Foam]) -> None:
        """Collect the geoms that the pad feels, simple ones first, and their pressure laws."""
        root = model.body_rootid[self._body]
        geom_body = model.geom_bodyid
        own = model.body_rootid[geom_body] == root if root else geom_body == self._body
        solid = ~own & ((model.geom_contype | model.geom_conaffinity) != 0)
        simple = np.flatnonzero(solid & np.isin(model.geom_type, _KINDS))
        meshes = np.flatnonzero(solid & (model.geom_type == _MESH))
        self._geoms = np.concatenate([simple, meshes])
        self._bodies = geom_body[self._geoms].astype(np.int64)
        weld = model.body_weldid[self._bodies]
        self._masses = np.where(weld == 0, np.inf, model.body_subtreemass[weld])
        radii = model.geom_rbound[self._geoms].copy()
        self._tables, self._laws = self._pressure_laws(model, softness)
        rows = np.ceil(2 * radii / _SAMPLE_SPACING_M)
        samples = np.clip(rows, _MIN_SAMPLES, _MAX_SAMPLES).astype(np.int32)
        count = len(simple)
        self._solids = SimpleSolids(
            positions=np.zeros((count, 3)),
            rotations=np.zeros((count, 9)),
            kinds=model.geom_type[simple].astype(np.int32),
            sizes=model.geom_size[simple].copy(),
            radii=radii[:count],
            laws=self._laws[:count],
            samples=samples[:count],
            masses=self._masses[:count],
        )
        self._meshes = [
            _mesh_solid(model, int(geom), float(radii[k]), float(self._masses[k]))
            for k, geom in enumerate(meshes, start=count)
        ]
        total = len(self._geoms)
        self._state = ContactState(
            np.zeros((total, POSE_FIELDS)), np.zeros((total, 6)), np.zeros(total)
        )
        self._solid_state = _rows(self._state, slice(count))

    def _pressure_laws(
        self, model: Any, softness: Mapping[str, Foam]
    ) -> tuple[PressureTables, NDArray[np.int32]]:
        """Tabulate the pressure for each foam, and return the table's row for each geom."""
        kinds: list[Foam | None] = [None, *dict.fromkeys(softness.values())]
        tables = [pressure_table(self.options.foam, kind) for kind in kinds]
        law = np.zeros(model.ngeom, np.int32)
        for name, foam in softness.items():
            law[_index_of(model.ngeom, model.geom, name, "geom")] = kinds.index(foam)
        pressures = np.array([table.pressures for table in tables])
        return PressureTables(pressures, np.array([t.step for t in tables])), law[self._geoms]


def _rows(state: ContactState, rows: slice) -> ContactState:
    return ContactState(state.poses[rows], state.wrenches[rows], state.stiffness[rows])


def _mesh_solid(model: Any, geom: int, radius: float, mass: float) -> MeshSolid:
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    return MeshSolid(
        position=np.zeros(3),
        rotation=np.zeros(9),
        radius=radius,
        vertices=model.mesh_vert[first : first + count].astype(float),
        faces=model.mesh_face[face : face + faces].astype(np.int32),
        mass=mass,
        buffer=np.empty((count, 3)),
    )


def _index_of(count: int, item: Any, name: str, kind: str) -> int:
    for number in range(count):
        if item(number).name == name:
            return number
    raise InputError(f"the model has no {kind} named {name!r}")
