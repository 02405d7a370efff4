"""Tactile fingertips: contact forces on the distal pads, spread over tactels as by a foam."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from eyehand.tactile import TactileArray, TactileImage

from ..pad.layer_shear import base_forces

ROWS, COLUMNS = 4, 3
"""Tactels along the finger and across it."""
PITCH_M = 0.005
"""Distance between the centres of two tactels."""
SPREAD_M = 0.0025
"""Standard deviation of the image of a point force through the pad's foam."""
LAYER_M = 0.002
"""Thickness of the foam, over which friction on the pad turns it."""


class FingertipPads:
    """Read the fingertips of a MuJoCo model.

    An array lies on the inner face of each pad, with its centre at the tip's site. Its rows run
    along the finger. Its sensor frame has x across the finger, y towards the tip and z out of the
    pad.

    Parameters
    ----------
    model
        `mujoco.MjModel`.
    pads
        Numbers of the geoms that carry an array; empty for a hand without tactile tips.
    sites
        Numbers of their sites in the inner face, in the same order.
    """

    def __init__(self, model: Any, pads: Sequence[int], sites: Sequence[int]) -> None:
        self.array = tip_array()
        self._sites = np.asarray(sites, dtype=np.int64)
        self._tip_of_geom = np.full(model.ngeom, -1, dtype=np.int64)
        self._tip_of_geom[list(pads)] = np.arange(len(pads))
        self._R_site_sensor = np.array(
            [_face(model, *pair) for pair in zip(pads, sites, strict=True)]
        )
        self._forces = np.zeros((len(pads), 3, ROWS, COLUMNS))
        self._base = np.zeros((3, ROWS, COLUMNS))

    def read(self, data: Any) -> tuple[TactileImage, ...]:
        """Return the exact image of each fingertip, from the contacts of the last physics step."""
        return tuple(TactileImage(row, self.array) for row in self.pressures(data))

    def pressures(self, data: Any, shear: float = 0.0) -> NDArray[np.float64]:
        """Return the pressures under each pad, (T, 12), Pa, from the contacts of the last step.

        The force of each contact along the pad's inward normal is spread over the tactels, so the
        forces of an image add up to the force on the pad.

        Parameters
        ----------
        data
            `MjData` after a physics step.
        shear
            Share of the foam's thickness over which friction turns it, 0..1. It moves the image,
            and pressures are negative where the foam pulls.
        """
        contact = data.contact
        self._forces[:] = 0.0
        if data.nefc and len(self._forces):
            contacts = _Contacts(
                contact.geom,
                contact.pos,
                contact.frame.reshape(-1, 9),
                contact.efc_address,
                contact.dim,
                data.efc_force,
            )
            tips = _Tips(
                self._tip_of_geom,
                data.site_xpos[self._sites],
                data.site_xmat[self._sites].reshape(-1, 3, 3),
                self._R_site_sensor,
            )
            _press(contacts, tips, self._forces)
            for forces in self._forces if shear > 0.0 else ():
                base_forces(forces, shear * LAYER_M, PITCH_M, PITCH_M, self._base)
                forces[0] = self._base[0]
        return self._forces[:, 0].reshape(-1, ROWS * COLUMNS) / self.array.area


def find_tips(
    model: Any, prefix: str, fingers: Sequence[str]
) -> tuple[FingertipPads, tuple[str, ...]]:
    """Find the fingertips with a pad ``<finger>_distal`` and a site ``<finger>_tip``.

    Parameters
    ----------
    model
        `mujoco.MjModel`.
    prefix
        Prefix of the hand's names.
    fingers
        Names of the fingers.

    Returns
    -------
    tuple[FingertipPads, tuple[str, ...]]
        The fingertips, and the names of their pads.
    """
    geoms = {model.geom(g).name: g for g in range(model.ngeom)}
    sites = {model.site(s).name: s for s in range(model.nsite)}
    found = [
        (f"{finger}_distal", geoms[f"{prefix}{finger}_distal"], sites[f"{prefix}{finger}_tip"])
        for finger in fingers
        if f"{prefix}{finger}_distal" in geoms and f"{prefix}{finger}_tip" in sites
    ]
    names, pads, places = zip(*found, strict=True) if found else ((), (), ())
    return FingertipPads(model, pads, places), names


@functools.cache
def tip_array() -> TactileArray:
    """Return the array of a fingertip: 4 rows along the finger, 3 columns."""
    return TactileArray.flat(ROWS, COLUMNS, PITCH_M)


def _face(model: Any, pad: int, site: int) -> NDArray[np.float64]:
    """Return R_site_sensor (3, 3) of the array on a pad."""
    turn = Rotation.from_quat(model.site_quat[site], scalar_first=True).as_matrix()
    pad_axes = Rotation.from_quat(model.geom_quat[pad], scalar_first=True).as_matrix()
    along = turn.T @ pad_axes[:, 2]
    out = turn.T @ (model.site_pos[site] - model.geom_pos[pad])
    out = out - along * np.vdot(along, out)
    out = out / np.linalg.norm(out)
    return np.column_stack([np.cross(along, out), along, out])


class _Contacts(NamedTuple):
    """Contacts of the last physics step (``data.contact``)."""

    geoms: NDArray
    """(C, 2), the two geoms."""
    points: NDArray
    """(C, 3), world, m."""
    frames: NDArray
    """(C, 9), the first row is the normal from the first geom to the second, the others are the
    directions of friction."""
    rows: NDArray
    """(C,), first row in `solved`; negative if the contact has none."""
    dimensions: NDArray
    """(C,), number of rows: 1 without friction."""
    solved: NDArray
    """Constraint forces, N (``data.efc_force``)."""


class _Tips(NamedTuple):
    """Fingertip arrays."""

    of_geom: NDArray
    """Array on each geom; -1 for none."""
    positions: NDArray
    """(T, 3), their sites, world, m."""
    rotations: NDArray
    """(T, 3, 3), world from site."""
    R_site_sensor: NDArray
    """(T, 3, 3), site from sensor."""


@njit(cache=True)
def _press(contacts, tips, forces):
    """Add the force of each contact, (T, 3, rows, columns), to the tip that it presses on.

    The components are the normal force, and the friction along x and y of the sensor.
    """
    force = np.empty(3)
    across, along = np.empty(COLUMNS), np.empty(ROWS)
    geoms, points, frames = contacts.geoms, contacts.points, contacts.frames
    rows, solved = contacts.rows, contacts.solved
    for k in range(len(geoms)):
        # In an elliptic cone the first row of a contact is its normal force.
        if rows[k] < 0 or solved[rows[k]] <= 0.0:
            continue
        for side in range(2):
            tip = tips.of_geom[geoms[k, side]]
            if tip < 0:
                continue
            turn = tips.rotations[tip] @ tips.R_site_sensor[tip]
            # The normal points from the first geom to the second: inwards on the second.
            inward = 0.0
            x, y = 0.0, 0.0
            sign = 1.0 if side == 1 else -1.0
            for i in range(3):
                inward -= sign * frames[k, i] * turn[i, 2]
                x += turn[i, 0] * (points[k, i] - tips.positions[tip, i])
                y += turn[i, 1] * (points[k, i] - tips.positions[tip, i])
            if inward <= 0.0:
                continue
            _imprint(x, across)
            _imprint(y, along)
            force[:] = 0.0
            force[0] = inward * solved[rows[k]]
            # In an elliptic cone the rows after the normal are friction.
            for row in range(1, min(contacts.dimensions[k], 3)):
                pull = sign * solved[rows[k] + row]
                for i in range(3):
                    force[1] += pull * frames[k, 3 * row + i] * turn[i, 0]
                    force[2] += pull * frames[k, 3 * row + i] * turn[i, 1]
            for part in range(3):
                for r in range(ROWS):
                    for c in range(COLUMNS):
                        forces[tip, part, r, c] += force[part] * along[r] * across[c]


@njit(cache=True)
def _imprint(offset, shares):
    """Compute the share of a point force on each tactel of a row; shares add up to 1."""
    count = len(shares)
    half = 0.5 * count * PITCH_M
    # A force beside the array counts at its border.
    offset = min(max(offset, -half), half)
    total = 0.0
    scale = 1.0 / (math.sqrt(2.0) * SPREAD_M)
    last = math.erf((-half - offset) * scale)
    for k in range(count):
        here = math.erf(((k + 1) * PITCH_M - half - offset) * scale)
        shares[k] = here - last
        total += shares[k]
        last = here
    for k in range(count):
        shares[k] /= total
