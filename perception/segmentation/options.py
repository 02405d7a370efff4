"""Every threshold of the segmentation, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import inf, nan
from numbers import Integral, Real
from typing import Any

import numpy as np

from eyehand.errors import InputError

REFERENCE_WIDTH = 640
"""Image width for which pixel counts are meant."""
MAX_LINES = 1000
"""Most lines between two patches: their fixed shuffle is none beyond."""
MIN_WINDOW = 5
"""Smallest side of a scaled window, px: below it a plane fit averages nothing."""


@dataclass(frozen=True)
class SegmentationOptions:
    """Options of :func:`segment`.

    Lengths and areas in pixels are meant for an image 640 px wide; see :meth:`scaled`.

    Raises
    ------
    InputError
        If a value is not positive, or the window is even.
    """

    window: int = 9
    """Side of the local plane fit, px, odd: wider averages more noise and blurs thin parts."""
    median: bool = True
    """3x3 median before the fit: removes single flying pixels, rounds one-pixel details."""
    min_noise: float = 1e-3
    """Floor of the disparity noise σ, 1/m: keeps noise-free frames from breaking every link."""
    noise_quantile: float = 0.4
    """Quantile of the windows' residuals that is taken for the noise: below the median, because
    windows across an edge are no measure of it."""
    shift_gain: float = 0.6
    """A shifted window replaces the centred one when its error is below this share of it: lower
    keeps windows centred (smoother), higher sharpens creases (noisier)."""
    link_angle: float = 0.14
    """Largest angle between the planes of linked neighbours, rad: lower splits curved surfaces,
    higher merges across shallow creases."""
    link_sigmas: float = 3.0
    """Largest disagreement of neighbouring planes, in σ: lower breaks noisy surfaces, higher
    merges across small steps."""
    min_patch: int = 40
    """Smallest smooth patch, px: lower keeps thin objects, higher drops clutter from noise."""
    plane_candidates: int = 120
    """Planes tried as the support: more finds small tables, costs time."""
    plane_sigmas: float = 3.0
    """Band around the support plane that counts as the plane, in σ."""
    min_height: float = 0.006
    """Least height above the support of an object's points, m: lower finds flat objects, higher
    ignores wavy tables."""
    max_tilt: float = 0.35
    """Largest angle between support normal and gravity when the camera's place is known, rad."""
    hull_margin: float = 0.01
    """How far outside the support's hull an object's foot may stand, m."""
    table_height: float | None = None
    """Height of the support in the world frame, m, where it is known with the camera's place."""
    table_tolerance: float = 0.05
    """How far from that height a support may lie, m."""
    min_table: float = 0.15
    """Least seen area of a further support, m²: smaller parallel planes are faces of objects."""
    overhang: float = 0.15
    """How far outside the support's bounds in plan an object may reach, m: higher sees more of
    what hangs over the edge, and more of walls and people behind."""
    max_range: float = 4.0
    """Readings farther away are no objects, m: the robot's reach."""
    max_extent: float = 0.8
    """Largest object, m along its bounds' diagonal: larger things are walls, arms, furniture."""
    grow_sigmas: float = 6.0
    """Largest distance of a border pixel from the plane of the patch it joins, in σ."""
    rim_sigmas: float = 30.0
    """The same for what is left after that, in σ: lower leaves rims of round objects as pieces
    of their own, higher lets thin parts join what is behind them."""
    concave_angle: float = 0.25
    """Mean concavity of a border that separates two patches, rad: lower cuts bent objects,
    higher joins touching ones."""
    crease_sigmas: float = 18.0
    """Largest change of slope over a border that counts as a crease instead of a step, in σ per
    px: lower cuts off faces seen at a grazing angle, higher joins what is behind a round rim."""
    bend_reach: int = 4
    """How far across a border the bend is measured, px: longer is surer, shorter sees smaller
    parts."""
    bend_sigmas: float = 3.0
    """Bend in disparity that counts as a full vote, in σ."""
    contact_share: float = 0.25
    """Least share of a border without a depth step for two patches to touch at all."""
    crossing_share: float = 0.25
    """Largest share of lines between two parts of one object that may cross free space: lower
    cuts bent objects, higher joins neighbours that touch."""
    bulge_turn: float = 0.5
    """How much two parts must bulge from one to the other to be joined across a step: lower joins
    neighbours, higher cuts off faces seen at a grazing angle."""
    bulge_crossing_share: float = 0.1
    """Largest share of lines between such parts that may cross free space."""
    line_samples: int = 48
    """Lines tried between two patches: more are surer, and cost time."""
    free_depth: float = 0.003
    """How far in front of the surface behind it a point is in free space, m."""
    min_border: int = 8
    """Least number of border pixel pairs that can join two patches."""
    min_object: int = 120
    """Smallest object, px: lower finds far objects, higher ignores noise."""
    gap_reach: int = 16
    """Widest strip without readings over which two regions still are neighbours, px: the shadow
    that a projector or a second lens leaves beside an object."""
    hollow_turn: float = 0.35
    """How hollow the inside of a vessel is (0 = flat, 1 = hollow everywhere): lower takes the
    backs of bent sheets for vessels, higher misses shallow bowls."""
    min_hollow: int = 300
    """Smallest inside of a vessel, px: of fewer pixels noise can make a hollow."""
    hidden_angle: float = 0.4
    """Largest angle between the two ends of a continued surface, rad."""
    hidden_dent: float = 0.15
    """The same where the surface bends inwards, rad: what no convex solid does."""
    min_rim_share: float = 0.25
    """Least share of a vessel's mouth along which its outside is seen: lower joins neighbours."""
    max_floor: float = 2.0
    """Largest size of a vessel's floor, of the inside that was seen: higher fills wide pots,
    and takes the table between objects for a floor."""
    max_hanging: float = 0.006
    """Largest seen area of a hanging piece, m²: what a handle or a knob has."""
    hanging_share: float = 0.5
    """Largest size of a hanging piece, of what it hangs on."""
    hanging_height: float = 0.4
    """Least height at which a hanging piece begins, of its own extent in height: a ball seen
    from above at 60° begins at a third."""
    free_share: float = 0.8
    """Share of a piece's lower edge below which there is nothing, for it to hang: lower joins
    what stands behind a low object, higher leaves handles alone."""
    hidden_reach: int = 160
    """Longest way behind an occluder over which surfaces are continued, px."""
    hidden_sigmas: float = 4.0
    """Largest disagreement of a continued surface, in σ."""
    hidden_growth: float = 0.25
    """Growth of that with every px of the way, in σ: a slope's own uncertainty."""
    hidden_slope_sigmas: float = 0.9
    """Largest change of slope of a continued surface, in σ per px."""
    hidden_share: float = 0.2
    """Least share of the border pixels that find their continuation: lower joins what only
    happens to be aligned."""
    min_hidden: int = 12
    """Least number of such pixels."""
    fragment: int = 600
    """Smaller regions are fragments when they touch a far larger one, px."""
    fragment_border: float = 0.3
    """Least share of a fragment's outline that touches the region that it goes to."""
    close_gap: float = 0.02
    """Largest depth step between a fragment and what it belongs to, m."""
    fragment_share: float = 0.12
    """Largest size of a fragment, of that region's."""
    stride: int = 1
    """Every stride-th row and column is segmented: 2 costs a quarter of the time and blurs
    outlines by as many pixels; labels keep the frame's size."""
    threads: int = 1
    """Threads of the window stages: 2 shorten them on free cores, cost on busy ones."""
    shift_windows: bool = True
    """Windows may shift to one side of an edge: off is faster and blurs creases."""
    join_open: bool = True
    """Join the inside of an open object (bowl, mug, pot) to its outside."""
    join_occluded: bool = True
    """Join the parts of one object that an occluder cuts in two."""
    colour_edges: bool = True
    """Where the frame has colour, cut objects along strong colour edges that geometry leaves
    ambiguous."""
    colour_contrast: float = 0.08
    """Least distance of the two colours of a cut, in shares of red, green and blue: lower cuts
    where coloured light falls on one face more than on another."""
    colour_purity: float = 0.85
    """Least share of an object's colour variance that two plain colours explain: lower cuts
    printed boxes."""
    colour_straightness: float = 0.96
    """Least share of pixels that one plane puts on the side of their colour."""
    flat_angle: float = 0.06
    """Mean bend of a border below which two parts are one or two: they are named ambiguous, rad."""
    flat_share: float = 0.15
    """Least share of an object on either side of a border for that."""
    split_gain: float = 2.0
    """How much closer two solids must fit than one to split an object."""
    split_spread: float = 0.004
    """Spread about one solid below which an object is never split, m."""
    split_solids: bool = False
    """Fit one and two solids to every ambiguous object, and split it where two explain it clearly
    better: costs tens of ms an object that is in doubt."""

    def __post_init__(self) -> None:
        for field in fields(self):
            _check(field.name, str(field.type), getattr(self, field.name))
        if self.noise_quantile > 1:
            raise InputError(f"noise_quantile is a share of at most 1, got {self.noise_quantile}")
        if self.line_samples > MAX_LINES:
            raise InputError(f"line_samples must be <= {MAX_LINES}, got {self.line_samples}")
        if self.window % 2 == 0 or self.window < 3:
            raise InputError(f"window must be odd and >= 3 px, got {self.window}")

    @classmethod
    def for_budget(
        cls, milliseconds: float, *, slower: float = 1.0, threads: int = 2
    ) -> SegmentationOptions:
        """Pick the most accurate settings for a time budget in ms: see `options_for_budget`."""
        from .budget import options_for_budget

        return options_for_budget(milliseconds, slower=slower, threads=threads)

    def scaled(self, width: int) -> SegmentationOptions:
        """Give the options for an image `width` px wide: equal angles are other pixel counts."""
        scale = width / REFERENCE_WIDTH
        return replace(
            self,
            window=max(2 * round((self.window * scale - 1) / 2) + 1, MIN_WINDOW),
            min_patch=max(round(self.min_patch * scale**2), 1),
            min_border=max(round(self.min_border * scale), 1),
            bend_reach=max(round(self.bend_reach * scale), 1),
            gap_reach=max(round(self.gap_reach * scale), 1),
            hidden_reach=max(round(self.hidden_reach * scale), 1),
            min_hidden=max(round(self.min_hidden * scale), 1),
            min_hollow=max(round(self.min_hollow * scale**2), 1),
            fragment=max(round(self.fragment * scale**2), 1),
            min_object=max(round(self.min_object * scale**2), 1),
        )


def _check(name: str, kind: str, value: Any) -> None:
    """Raise an `InputError` unless a value is of its field's kind, finite and positive."""
    if value is None and "None" in kind:
        return
    if kind == "bool":
        if not isinstance(value, bool):
            raise InputError(f"segmentation option {name} must be true or false, got {value!r}")
        return
    numbers, word = (Integral, "a whole number") if kind == "int" else (Real, "finite")
    amount = nan
    if isinstance(value, numbers) and not isinstance(value, bool):
        amount = np.float64(value)
    least = -inf if name == "table_height" else 0.0
    if not least < amount < inf:
        bound = "" if least < 0 else " and > 0"
        raise InputError(f"segmentation option {name} must be {word}{bound}, got {value!r}")
