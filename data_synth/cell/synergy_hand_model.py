"""Measure opening widths and reach of a hand with joint motors while its fingers close."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.grasping import HandModel
from eyehand.grasping.hands import PINCER_FINGER

from ..mujoco_import import import_mujoco
from .geom_extent import extent
from .hand_description import THUMB, HandDescription
from .hand_frame import find_frame
from .synergy_drives import SynergyDrives

STEPS = 41
"""Postures measured from open to closed; widths between them are interpolated."""
ROWS = 13
"""Rows of the hand model's table of openings."""
MIN_RANGE_M = 0.01
"""Minimum difference between the widest and the narrowest opening of a usable hand."""
MAX_CLOSED_M = 0.03
"""Maximum opening of the closed hand: a wider one cannot hold what a pincer grasp is for."""


def synergy_hand_model(
    model: Any, description: HandDescription, frame: str, *, prefix: str = ""
) -> HandModel:
    """Measure a hand with joint motors from its kinematics.

    Parameters
    ----------
    model
        `MjModel` of the hand, or of a whole robot.
    description
        Joints and pads of each finger.
    frame
        Site or body that is the hand's frame, prefix included.
    prefix
        Prefix of the description's names in the model.

    Raises
    ------
    InputError
        If the frame, a joint or a geom is missing, or fingers and thumb do not close towards each
        other from both sides of the frame's yz plane.
    """
    hand = _Posed(model, description, frame, prefix)
    closing = np.linspace(0.0, 1.0, STEPS)
    halves = hand.half_widths(closing)
    low, high = 2.0 * max(halves[-1].max(), 0.0), 2.0 * halves[0].min()
    if (np.diff(halves, axis=0) >= 0).any() or high - low < MIN_RANGE_M or low > MAX_CLOSED_M:
        measured = "; ".join(
            f"{name} {1e3 * halves[0, k]:.0f} to {1e3 * halves[-1, k]:.0f} mm"
            for k, name in enumerate(hand.drives.drives)
        )
        raise InputError(
            "fingers and thumb must close towards each other. Distance of each tip's face from the "
            f"yz plane of {frame}, open to closed (the thumb on the +x side): {measured}. It must "
            f"decrease, to an opening of at most {1e3 * MAX_CLOSED_M:.0f} mm"
        )
    openings = np.linspace(low, high, ROWS)
    excursions = np.array([[_closing_share(w / 2, closing, h) for h in halves.T] for w in openings])
    excursions *= hand.full
    reaches, outer_widths = np.empty(ROWS), np.empty(ROWS)
    for k, pulled in enumerate(excursions):
        hand.drives.pose(pulled)
        hand.update()
        reaches[k] = hand.bounds(hand.tips, 2)[1]
        outer_widths[k] = np.ptp(hand.bounds(hand.geoms, 0))
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
        outer_widths=outer_widths,
        row_width=float(np.ptp(hand.bounds(hand.geoms, 1))),
        pinch_width=float(np.ptp(hand.bounds([g for k in pincer for g in hand.pads[k]], 1))),
        thickness=float(np.ptp(hand.bounds(hand.tips[:1], 0))),
        palm_depth=-hand.bounds(hand.geoms, 2)[0],
        finger_rows=tuple(0.5 * sum(hand.bounds([tip], 1)) for tip in hand.tips[:-1]),
        finger_width=float(np.ptp(hand.bounds(hand.tips[:1], 1))),
    )


class _Posed:
    """A hand posed without physics, with measurements in its own frame."""

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
            if _is_descendant(model, int(model.geom_bodyid[g]), body)
            and model.geom_contype[g] | model.geom_conaffinity[g]
        ]
        self.full = self.drives.full

    def update(self) -> None:
        """Compute the positions of all geoms from the joint positions."""
        self._mujoco.mj_kinematics(self._model, self._data)

    def bounds(self, geoms: Any, axis: int) -> tuple[float, float]:
        """Return the smallest and largest coordinate of geoms along an axis of the frame, m."""
        data = self._data
        if self._site < 0:
            place, turn = data.xpos[self._body], data.xmat[self._body]
        else:
            place, turn = data.site_xpos[self._site], data.site_xmat[self._site]
        along = turn.reshape(3, 3)[:, axis]
        low, high = extent(self._model, data, geoms, along)
        start = float(along @ place)
        return low - start, high - start

    def half_widths(self, closing: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distance of each tip's face from the yz plane, (steps, D), m.

        `closing` (steps,) is 0 for the open and 1 for the closed posture. The distance is negative
        beyond the plane.
        """
        halves = np.empty((len(closing), len(self.tips)))
        for row, share in zip(halves, closing, strict=True):
            self.drives.pose(share * self.full)
            self.update()
            for k, tip in enumerate(self.tips):
                low, high = self.bounds([tip], 0)
                row[k] = low if self.drives.drives[k] == THUMB else -high
        return halves


def _is_descendant(model: Any, body: int, root: int) -> bool:
    while body > 0 and body != root:
        body = int(model.body_parentid[body])
    return body == root


def _closing_share(half: float, closing: NDArray[np.float64], halves: NDArray[np.float64]) -> float:
    """Interpolate how far a finger closes (0 to 1) until its face is at a half width, m."""
    return float(np.interp(half, halves[::-1], closing[::-1]))
