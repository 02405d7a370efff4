"""Measure opening widths and reach of a tendon hand from its MJCF file.

In the unloaded hand, springs and tendons balance at each joint: k (q - q0) = Σ r T, within the
joint's range. So kinematics alone gives every opening, without a physics step.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root_scalar

from eyehand.errors import InputError
from eyehand.grasping import HandModel
from eyehand.grasping.hands import PALM, PINCER_FINGER, THUMB

from ..arms import HAND
from ..mujoco_import import import_mujoco
from .tendon_drives import TendonDrives, tendon_arms

PALM_SITE = "palm"
"""Site of the hand frame: origin in the middle of the palm's face, z out of it."""

OPENINGS = np.linspace(0.0, 0.144, 13)
"""Opening widths in the table, m; those that the hand cannot reach are left out."""
_MAX_PULL_N, _MAX_WRAP_N = 60.0, 30.0
"""Tensions that close the unloaded hand and bend its outer joints completely."""
_MAX_BEND_RAD = 1.0
"""Pad angle reported when a finger is bent so far that it cannot open to the asked width."""
_WRAPS = {"wrap": False, "thumb_wrap": True}
"""Tendons of the outer joints → whether they belong to the thumb."""


def tendon_hand_model(spec: Any = HAND, *, frame: str = PALM_SITE, prefix: str = "") -> HandModel:
    """Measure a tendon hand from its kinematics.

    Fingers are found by their pads' names (``index_distal``), the thumb by the name ``thumb``.
    If the pads would open towards the fingertips, the tendons of the outer joints bend the fingers
    until the pads are parallel. Otherwise the pads would squeeze round objects out.

    Parameters
    ----------
    spec
        An `MjSpec` of the hand alone, or the path of its MJCF file.
    frame
        Site that is the hand's frame, prefix included. A path always uses the default.
    prefix
        Prefix of all names of the hand. A path always uses none.

    Raises
    ------
    InputError
        If the hand has no such site or no thumb, or a joint without an opening spring.
    """
    if isinstance(spec, (str, Path)):
        return _measure_file(str(spec))
    return _measure(spec.compile(), frame, prefix)


@functools.lru_cache(maxsize=4)
def _measure_file(path: str) -> HandModel:
    return _measure(import_mujoco().MjModel.from_xml_path(path), PALM_SITE, "")


def _measure(model: Any, frame: str, prefix: str) -> HandModel:
    hand = _Unloaded(model, frame, prefix)
    rows = [row for row in map(hand.measure_opening, OPENINGS) if row is not None]
    if len(rows) < 2:
        raise InputError(
            "fingers and thumb of the hand must reach two of the openings "
            f"{OPENINGS[0]:g} to {OPENINGS[-1]:g} m, got {len(rows)}"
        )
    hand.pose(rows[0].angles)
    row_low, row_high = hand.bounds(range(model.ngeom), 1)
    pinching = (PINCER_FINGER,) if PINCER_FINGER in hand.fingers else hand.fingers[:-1]
    middle = [
        g
        for g in range(model.ngeom)
        if hand.names[g].startswith((*pinching, THUMB)) and PALM not in hand.names[g]
    ]
    middle_low, middle_high = hand.bounds(middle, 1)
    tip_low, tip_high = hand.bounds([hand.tips[pinching[0]]], 0, turned=False)
    return HandModel(
        drives=hand.drives.drives,
        joints=hand.drives.joints,
        pads=hand.drives.pads,
        fingers=hand.fingers,
        openings=np.array([row.opening for row in rows]),
        reaches=np.array([row.reach for row in rows]),
        excursions=np.array([row.excursions for row in rows]),
        outer_widths=np.array([row.outer_width for row in rows]),
        row_width=row_high - row_low,
        pinch_width=middle_high - middle_low,
        thickness=tip_high - tip_low,
        palm_depth=-hand.bounds(range(model.ngeom), 2)[0],
        finger_rows=tuple(
            0.5 * sum(hand.bounds([hand.tips[finger]], 1)) for finger in hand.fingers[:-1]
        ),
        finger_width=float(np.ptp(hand.bounds([hand.tips[pinching[0]]], 1, turned=False))),
    )


@dataclass(frozen=True)
class _Row:
    """One row of the hand model's table, with the joint angles (J,), rad."""

    opening: float
    reach: float
    outer_width: float
    angles: NDArray[np.float64]
    excursions: NDArray[np.float64]


class _Unloaded:
    """The hand without an object, posed by tendon tensions."""

    def __init__(self, model: Any, frame: str, prefix: str) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._model, self._data = mujoco, model, mujoco.MjData(model)
        self.drives = TendonDrives(model, self._data, prefix=prefix)
        self.names = [_geom_name(model, g, prefix) for g in range(model.ngeom)]
        pads = {name: g for g, name in enumerate(self.names) if name in self.drives.pads}
        self.fingers = tuple(
            dict.fromkeys(name.rpartition("_")[0] for name in pads if name.endswith("_distal"))
        )
        if THUMB not in self.fingers or len(self.fingers) < 2:
            raise InputError(
                "a hand needs fingers and a thumb with pads <finger>_distal, thumb_distal; "
                f"found {', '.join(self.fingers) or 'none'}"
            )
        self.fingers = (*(f for f in self.fingers if f != THUMB), THUMB)
        self.tips = {finger: pads[f"{finger}_distal"] for finger in self.fingers}
        self._site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, frame)
        if self._site < 0:
            raise InputError(f"the hand has no site {frame.removeprefix(prefix)!r} for its frame")
        self._arms = -np.array([tendon_arms(model, t) for t in range(model.ntendon)])
        # Some versions of MuJoCo have further columns with the coefficients of a polynomial.
        self._stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[:, 0]
        loose = np.flatnonzero(self._stiffness <= 0)
        if loose.size:
            raise InputError(f"joint {self.drives.joints[loose[0]]} has no spring that opens it")

    def pose(self, angles: NDArray[np.float64]) -> None:
        """Set the joint angles (J,), rad."""
        self._data.qpos[:] = angles
        self._mujoco.mj_kinematics(self._model, self._data)

    def balance(self, tensions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the joint angles (J,), rad, at which springs balance tensions (D,), N."""
        rest = self._model.qpos_spring + (self._arms.T @ tensions) / self._stiffness
        return np.clip(rest, *self._model.jnt_range.T)

    def measure_opening(self, opening: float) -> _Row | None:
        """Measure the hand at an opening, m; return None if it cannot reach it."""
        names = self.drives.drives
        tensions = np.zeros(len(names))
        for thumb in (False, True):
            wraps = [k for k, name in enumerate(names) if _WRAPS.get(name) is thumb]
            pulls = [k for k, name in enumerate(names) if name not in _WRAPS]
            pulls = [k for k in pulls if self._moves_thumb(k) is thumb]
            finger = THUMB if thumb else self.fingers[0]
            if not self._open_finger(opening / 2, finger, pulls, wraps, tensions):
                return None
        angles = self.balance(tensions)
        self.pose(angles)
        tips = list(self.tips.values())
        low, high = self.bounds(range(self._model.ngeom), 0)
        closed = self._model.jnt_range[:, 0]
        return _Row(
            opening=float(opening),
            reach=self.bounds(tips, 2)[1],
            outer_width=high - low,
            angles=angles,
            excursions=self._arms @ (angles - closed),
        )

    def bounds(self, geoms: Any, axis: int, *, turned: bool = True) -> tuple[float, float]:
        """Return the smallest and largest coordinate of geoms along an axis of the hand, m.

        Boxes around the geoms are turned with them; `turned=False` measures along their own axes.
        """
        data, model = self._data, self._model
        place = data.site_xpos[self._site]
        axes = data.site_xmat[self._site].reshape(3, 3)
        low, high = np.inf, -np.inf
        for g in geoms:
            turn = axes.T @ data.geom_xmat[g].reshape(3, 3) if turned else np.eye(3)
            centre, half = model.geom_aabb[g, :3], model.geom_aabb[g, 3:]
            middle = axes[:, axis] @ (data.geom_xpos[g] - place) + turn[axis] @ centre
            low = min(low, middle - np.abs(turn[axis]) @ half)
            high = max(high, middle + np.abs(turn[axis]) @ half)
        return float(low), float(high)

    def _moves_thumb(self, drive: int) -> bool:
        joint = int(np.argmax(np.abs(self._arms[drive])))
        return self.drives.joints[joint].startswith(THUMB)

    def _half_width(self, finger: str) -> float:
        """Return the distance from the hand's yz plane to a finger's pad, m."""
        low, high = self.bounds([self.tips[finger]], 0)
        return low if finger == THUMB else -high

    def _pad_angle(self, finger: str) -> float:
        """Return the angle by which a pad faces the palm, rad; negative if it faces away."""
        data = self._data
        axes = data.site_xmat[self._site].reshape(3, 3)
        turn = axes.T @ data.geom_xmat[self.tips[finger]].reshape(3, 3)
        inward = -1.0 if finger == THUMB else 1.0
        return float(-np.arcsin(np.clip(inward * turn[2, 0], -1.0, 1.0)))

    def _open_finger(
        self,
        half: float,
        finger: str,
        pulls: list[int],
        wraps: list[int],
        tensions: NDArray[np.float64],
    ) -> bool:
        """Find tensions that move a pad to a half width, m, and bend it until it faces inwards.

        The tensions (D,), N, are written in place. Return False if there are none.
        """

        def width_error(tension: float) -> float:
            tensions[pulls] = tension
            self.pose(self.balance(tensions))
            return self._half_width(finger) - half

        def pad_angle(tension: float) -> float:
            tensions[wraps] = tension
            # A finger bent too far cannot open to the width: the bound makes the search bend less.
            return self._pad_angle(finger) if _solve(width_error, _MAX_PULL_N) else _MAX_BEND_RAD

        tensions[wraps] = 0.0
        if not _solve(width_error, _MAX_PULL_N):
            return False
        if wraps and self._pad_angle(finger) < 0 and _solve(pad_angle, _MAX_WRAP_N) is None:
            tensions[wraps] = 0.0
            _solve(width_error, _MAX_PULL_N)
        return True


def _geom_name(model: Any, geom: int, prefix: str) -> str:
    """Return a geom's name; one without a name is called after its body."""
    body = model.body(int(model.geom_bodyid[geom])).name
    return model.geom(geom).name.removeprefix(prefix) or f"{body.removeprefix(prefix)} trim"


def _solve(function: Callable[[float], float], max_value: float) -> float | None:
    """Find a root in [0, max_value], and call the function there last; None if there is none."""
    low, high = function(0.0), function(max_value)
    if low * high > 0:
        return None
    root = float(root_scalar(function, bracket=(0.0, max_value), xtol=1e-4).root)
    function(root)
    return root
