"""Every threshold of the segmentation, with its unit and what it trades."""

from __future__ import annotations

from dataclasses import dataclass, replace

from eyehand.errors import InputError

REFERENCE_WIDTH = 640
"""Image width for which pixel counts are meant."""
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
    plane_candidates: int = 200
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
    contact_share: float = 0.35
    """Least share of a border without a depth step for two patches to touch at all."""
    min_border: int = 8
    """Least number of border pixel pairs that can join two patches."""
    min_object: int = 150
    """Smallest object, px: lower finds far objects, higher ignores noise."""
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
    split_solids: bool = False
    """Fit one and two solids to every ambiguous object, and split it where two explain it clearly
    better: costs tens of ms an object."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not isinstance(value, bool) and not 0 < value < float("inf"):
                raise InputError(f"segmentation option {name} must be finite and > 0, got {value}")
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
            min_object=max(round(self.min_object * scale**2), 1),
        )
