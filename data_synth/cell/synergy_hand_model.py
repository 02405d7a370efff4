"""How wide a hand of joints opens and how far it reaches, along the way that its fingers close."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError
from eyehand.grasping import HandModel
from eyehand.grasping.hand_names import PINCER_FINGER

from ..mujoco_import import import_mujoco
from .geom_extent import extent
from .hand_description import THUMB, HandDescription
from .hand_frame import find_frame
from .synergy_drives import SynergyDrives

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEPS = 41
"""Postures along the way from open to closed: the widths between are interpolated."""
ROWS = 13
"""Of the table."""
LEAST_RANGE_M = 0.01
"""A hand whose opening changes by less is no hand."""
CLOSED_M = 0.03
"""A hand that stays open wider than this, m, does not close on what a pincer is for."""


def synergy_hand_model(
    model: Any, description: HandDescription, frame: str, *, prefix: str = ""
) -> HandModel:
    """Measure a hand of joints by its kinematics.

    Parameters
    ----------
    model
        `MjModel` of the hand, or of a whole robot.
    description
        Which joints are which finger's.
    frame
        Site or body that is the hand's frame, prefix included.
    prefix
        What stands before the names of the description in the model.

    Raises
    ------
    InputError
        If the frame, a joint or a geom is missing, or fingers and thumb do not close against one
        another about the frame's yz plane.
    """
    hand = _Posed(model, description, frame, prefix)
    ways = np.linspace(0.0, 1.0, STEPS)
    halves = hand.half_widths(ways)
    low, high = 2.0 * max(halves[-1].max(), 0.0), 2.0 * halves[0].min()
    if (np.diff(halves, axis=0) >= 0).any() or high - low < LEAST_RANGE_M or low > CLOSED_M:
        told = "; ".join(
            f"{name} {1e3 * halves[0, k]:.0f} to {1e3 * halves[-1, k]:.0f} mm"
            for k, name in enumerate(hand.drives.drives)
        )
        raise InputError(
            "fingers and thumb must close against one another: from the middle of the palm, along "
            f"x of {frame}, their tips' faces stand off by {told} (open to closed; a thumb's are "
            "on the +x side), and each must shrink to near 0"
        )
    openings = np.linspace(low, high, ROWS)
    excursions = np.array([[_way(w / 2, ways, h) for h in halves.T] for w in openings])
    excursions *= hand.full
    reaches, spreads = np.empty(ROWS), np.empty(ROWS)
    for k, pulled in enumerate(excursions):
        hand.drives.pose(pulled)
        hand.update()
        reaches[k] = hand.bounds(hand.tips, 2)[1]
        spreads[k] = np.ptp(hand.bounds(hand.geoms, 0))
    hand.drives.pose(excursions[0])
    hand.update()
    pincer = [k for k, f in enumerate(description.fingers) if f.name in (PINCER_FINGER, THUMB)]
    if len(pincer) < 2:
        pincer = list(range(len(description.fingers)))
    return HandModel(
        drives=hand.drives.drives,
        joints=hand.drives.joints,
        pads=hand.drives.pads,
        fingers=hand.drives.drives,
        openings=openings,
        reaches=reaches,
        excursions=excursions,
        spreads=spreads,
        row=float(np.ptp(hand.bounds(hand.geoms, 1))),
        middle_row=float(np.ptp(hand.bounds([g for k in pincer for g in hand.pads[k]], 1))),
        thickness=float(np.ptp(hand.bounds(hand.tips[:1], 0))),
        palm_depth=-hand.bounds(hand.geoms, 2)[0],
    )


class _Posed:
    """A hand without physics, and what it measures in its own frame."""

    def __init__(self, model: Any, description: HandDescription, frame: str, prefix: str) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._model, self._data = mujoco, model, mujoco.MjData(model)
        self.drives = SynergyDrives(model, self._data, description, prefix=prefix)
        self.pads = [[model.geom(prefix + g).id for g in f.pads] for f in description.fingers]
        self.tips = [pads[-1] for pads in self.pads]
        body, self._site = find_frame(model, frame)
        self._body = body
        self.geoms = [
            g
            for g in range(model.ngeom)
            if _below(model, int(model.geom_bodyid[g]), body)
            and model.geom_contype[g] | model.geom_conaffinity[g]
        ]
        self.full = self.drives.full

    def update(self) -> None:
        self._mujoco.mj_kinematics(self._model, self._data)

    def bounds(self, geoms: Any, axis: int) -> tuple[float, float]:
        data = self._data
        if self._site < 0:
            place, turn = data.xpos[self._body], data.xmat[self._body]
        else:
            place, turn = data.site_xpos[self._site], data.site_xmat[self._site]
        along = turn.reshape(3, 3)[:, axis]
        low, high = extent(self._model, data, geoms, along)
        start = float(along @ place)
        return low - start, high - start

    def half_widths(self, ways: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distance of each tip's face from the yz plane, (steps, D), m; below 0 it is past."""
        halves = np.empty((len(ways), len(self.tips)))
        for row, way in zip(halves, ways, strict=True):
            self.drives.pose(way * self.full)
            self.update()
            for k, tip in enumerate(self.tips):
                low, high = self.bounds([tip], 0)
                row[k] = low if self.drives.drives[k] == THUMB else -high
        return halves


def _below(model: Any, body: int, root: int) -> bool:
    while body > 0 and body != root:
        body = int(model.body_parentid[body])
    return body == root


def _way(half: float, ways: NDArray[np.float64], halves: NDArray[np.float64]) -> float:
    """How far a finger closes until its face stands at a half width."""
    return float(np.interp(half, halves[::-1], ways[::-1]))
