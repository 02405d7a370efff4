"""What a hand's description says of it: how wide it opens, how far it reaches, tendon by tendon.

The unloaded hand is a balance of springs and tendons, joint by joint: k (q - q0) = Σ r T, within
the joint's range. So every opening is found from kinematics alone, without a physics step.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import root_scalar

from eyehand.errors import InputError
from eyehand.grasping import HandModel
from eyehand.grasping.hand_names import PALM, PINCER_FINGER, THUMB

from ..mujoco_import import import_mujoco
from .tendon_drives import TendonDrives, tendon_arms

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

HAND = Path(__file__).parent / "assets" / "hand.xml"
"""An underactuated hand: three fingers, each of three phalanges, against a thumb of two."""
PALM_SITE = "palm"
"""Site of the hand frame."""

OPENINGS = np.linspace(0.0, 0.144, 13)
"""Free widths in the table, m; those that the hand cannot make are left out."""
_MOST_PULL, _MOST_WRAP = 60.0, 30.0
"""Tensions, N, that close the unloaded hand and bend its outer joints all the way."""
_MAX_BEND = 1.0
_WRAPS = {"wrap": False, "thumb_wrap": True}
"""Tendons of the outer joints, and whether they are the thumb's."""


def tendon_hand_model(spec: Any = HAND, *, frame: str = PALM_SITE, prefix: str = "") -> HandModel:
    """Measure a hand by its kinematics.

    Fingers are found by their pads' names (``index_distal``), the thumb by the name ``thumb``.
    Where the pads would lean apart, the tendons of the outer joints bend the fingers until the
    pads are parallel: pads that lean apart squeeze round things out.

    Parameters
    ----------
    spec
        An `MjSpec` of the hand alone, or the path of its MJCF file.
    frame
        Site that is the hand's frame, prefix included; with a path the default only.
    prefix
        What stands before every name of the hand; with a path nothing.

    Raises
    ------
    InputError
        If the hand has no such site, no thumb, or a joint that no spring opens.
    """
    if isinstance(spec, (str, Path)):
        return _measure_file(str(spec))
    return _measure(spec.compile(), frame, prefix)


@functools.lru_cache(maxsize=4)
def _measure_file(path: str) -> HandModel:
    return _measure(import_mujoco().MjModel.from_xml_path(path), PALM_SITE, "")


def _measure(model: Any, frame: str, prefix: str) -> HandModel:
    hand = _Unloaded(model, frame, prefix)
    rows = [row for row in map(hand.opened, OPENINGS) if row is not None]
    if len(rows) < 2:
        raise InputError("the hand's fingers and thumb do not open against one another")
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
        spreads=np.array([row.spread for row in rows]),
        row=row_high - row_low,
        middle_row=middle_high - middle_low,
        thickness=tip_high - tip_low,
        palm_depth=-hand.bounds(range(model.ngeom), 2)[0],
    )


@dataclass(frozen=True)
class _Row:
    opening: float
    reach: float
    spread: float
    angles: NDArray[np.float64]
    excursions: NDArray[np.float64]


class _Unloaded:
    """A hand with nothing in it, posed by tensions."""

    def __init__(self, model: Any, frame: str, prefix: str) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._model, self._data = mujoco, model, mujoco.MjData(model)
        self.drives = TendonDrives(model, self._data, prefix=prefix)
        kinds = mujoco.mjtObj
        self.names = [
            (mujoco.mj_id2name(model, kinds.mjOBJ_GEOM, g) or "").removeprefix(prefix)
            for g in range(model.ngeom)
        ]
        for g in range(model.ngeom):
            if not self.names[g]:
                body = mujoco.mj_id2name(model, kinds.mjOBJ_BODY, model.geom_bodyid[g]) or ""
                self.names[g] = f"{body.removeprefix(prefix)} trim"
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
        site = mujoco.mj_name2id(model, kinds.mjOBJ_SITE, frame)
        if site < 0:
            told = frame.removeprefix(prefix)
            raise InputError(f"the hand has no site {told!r} for its frame")
        self._site = site
        arms = np.array([tendon_arms(model, t) for t in range(model.ntendon)])
        self._arms = -arms
        self._stiffness = np.ravel(model.jnt_stiffness)[: model.njnt]
        if model.jnt_stiffness.ndim > 1:
            self._stiffness = model.jnt_stiffness[:, 0]
        loose = np.flatnonzero(self._stiffness <= 0)
        if loose.size:
            raise InputError(f"joint {self.drives.joints[loose[0]]} has no spring that opens it")

    def pose(self, angles: NDArray[np.float64]) -> None:
        self._data.qpos[:] = angles
        self._mujoco.mj_kinematics(self._model, self._data)

    def balance(self, tensions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Angles at which springs and tendons balance."""
        rest = self._model.qpos_spring + (self._arms.T @ tensions) / self._stiffness
        return np.clip(rest, *self._model.jnt_range.T)

    def opened(self, opening: float) -> _Row | None:
        """The hand at a free width; None if it cannot open so far."""
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
            spread=high - low,
            angles=angles,
            excursions=self._arms @ (angles - closed),
        )

    def bounds(self, geoms: Any, axis: int, *, turned: bool = True) -> tuple[float, float]:
        """Least and largest coordinate of geoms along an axis of the hand, m."""
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

    def _half(self, finger: str) -> float:
        """Free width from the middle of the palm to a finger's pad."""
        low, high = self.bounds([self.tips[finger]], 0)
        return low if finger == THUMB else -high

    def _lean(self, finger: str) -> float:
        """How much a pad faces the palm, rad; negative where it faces away."""
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
        """Find tensions that bring a finger's pad to a half width, bent until it faces inwards."""

        def missing(tension: float) -> float:
            tensions[pulls] = tension
            self.pose(self.balance(tensions))
            return self._half(finger) - half

        def leaning(tension: float) -> float:
            tensions[wraps] = tension
            # Bent so far that it cannot open to the width any more: less bend is asked.
            return self._lean(finger) if _solve(missing, _MOST_PULL) else _MAX_BEND

        tensions[wraps] = 0.0
        if not _solve(missing, _MOST_PULL):
            return False
        if wraps and self._lean(finger) < 0 and _solve(leaning, _MOST_WRAP) is None:
            tensions[wraps] = 0.0
            _solve(missing, _MOST_PULL)
        return True


def _solve(function: Callable[[float], float], most: float) -> float | None:
    """Root between 0 and a bound, with the function called there last; None without one."""
    low, high = function(0.0), function(most)
    if low * high > 0:
        return None
    root = float(root_scalar(function, bracket=(0.0, most), xtol=1e-4).root)
    function(root)
    return root
