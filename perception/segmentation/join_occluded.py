"""Parts of one object on both sides of something nearer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .ambiguity import HIDDEN, Doubt
from .convexity import pixels_by_label
from .free_space import crossings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .local_planes import LocalPlanes
    from .options import SegmentationOptions

LOOK, MATCH = range(2)


def join_occluded(
    labels: NDArray[np.int32],
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    camera: CameraIntrinsics,
    options: SegmentationOptions,
) -> tuple[NDArray[np.int32], list[Doubt]]:
    """Join regions (H, W) whose surfaces continue one another behind an occluder.

    From every border pixel of a region its plane is followed in eight directions for as long as
    what was measured lies before that plane, or nothing was measured. Where it comes out on
    another region, that region's plane must lie in its continuation, and may not bend inwards.
    Two regions are joined when enough of the pixels that see the other one agree, and the lines
    between them cross no free space: between two balls behind a third they would.

    Returns
    -------
    labels, doubts
        New labels, and the pairs that were joined: two objects may just be aligned.
    """
    count = int(labels.max(initial=0))
    if count < 2:
        return labels, []
    votes = hidden_votes(
        labels,
        disparity,
        planes.value,
        planes.slope_u,
        planes.slope_v,
        count,
        options.hidden_reach,
        options.window // 2 + 2,
        np.float32(options.grow_sigmas * planes.noise),
        np.float32(options.hidden_sigmas * planes.noise),
        np.float32(options.hidden_growth * planes.noise),
        np.float32(options.hidden_slope_sigmas * planes.noise),
        camera.fx,
        np.float32(np.tan(options.hidden_angle)),
        np.float32(np.tan(options.hidden_dent)),
    )
    parent = np.arange(count + 1, dtype=np.int32)
    order, starts = pixels_by_label(labels, count)
    doubts: list[Doubt] = []
    look = votes[..., LOOK] + votes[..., LOOK].T
    match = votes[..., MATCH] + votes[..., MATCH].T
    share = match / np.maximum(look, 1)
    likely = np.argwhere(np.triu((match >= options.min_hidden) & (share >= options.hidden_share)))
    if not len(likely):
        return labels, []
    solid = np.zeros(count + 1, bool)
    crossed = crossings(labels, likely, solid, disparity, planes.noise, camera, options)
    for (a, b), lines in zip(likely.tolist(), crossed, strict=True):
        if lines <= options.crossing_share * options.line_samples:
            doubts.append((int(order[starts[a]]), int(order[starts[b]]), HIDDEN))
            low, high = sorted((int(parent[a]), int(parent[b])))
            parent[parent == high] = low
    return parent[labels], doubts


@njit(cache=True, nogil=True)
def hidden_votes(
    labels,
    q,
    value,
    slope_u,
    slope_v,
    count,
    reach,
    inset,
    min_step,
    tolerance,
    growth,
    max_slope,
    focal,
    max_turn,
    max_dent,
):
    """Count per pair the pixels that see the other behind something, and that agree with it."""
    rows, columns = labels.shape
    votes = np.zeros((count + 1, count + 1, 2), np.int32)
    best = np.zeros(count + 1, np.int8)
    landed = np.empty(8, np.int32)
    for v in range(rows):
        for u in range(columns):
            a = labels[v, u]
            if a == 0:
                continue
            hits = 0
            for dv in range(-1, 2):
                for du in range(-1, 2):
                    y, x = v + dv, u + du
                    if (dv == 0 and du == 0) or y < 0 or x < 0 or y >= rows or x >= columns:
                        continue
                    if labels[y, x] == a:
                        continue
                    # Readings at an outline are bent: the plane is taken from further inside.
                    iv, iu = v - inset * dv, u - inset * du
                    if iv < 0 or iu < 0 or iv >= rows or iu >= columns:
                        continue
                    if labels[iv, iu] != a or value[iv, iu] <= 0:
                        continue
                    slope = slope_u[iv, iu] * du + slope_v[iv, iu] * dv
                    start = value[iv, iu] + slope * inset
                    for step in range(1, reach):
                        y, x = v + step * dv, u + step * du
                        if y < 0 or x < 0 or y >= rows or x >= columns:
                            break
                        if q[y, x] <= 0:
                            continue
                        allowed = tolerance + growth * (step + inset)
                        b = labels[y, x]
                        if q[y, x] - start - slope * step > max(allowed, min_step):
                            if b == 0:
                                break
                            continue
                        if b == 0 or b == a or step < 3:
                            break
                        y, x = y + inset * dv, x + inset * du
                        if y < 0 or x < 0 or y >= rows or x >= columns:
                            break
                        if labels[y, x] != b or value[y, x] <= 0:
                            break
                        way = step + inset
                        allowed = tolerance + growth * (way + inset)
                        # A plane turned by a small angle changes its slope by q / f of that.
                        slope_tolerance = min(max_slope, max_turn * value[y, x] / focal)
                        back = slope_u[y, x] * du + slope_v[y, x] * dv
                        good = (
                            abs(value[y, x] - start - slope * way) <= allowed
                            and abs(value[y, x] - back * way - start) <= allowed
                            and abs(slope_u[y, x] - slope_u[iv, iu]) <= slope_tolerance
                            and abs(slope_v[y, x] - slope_v[iv, iu]) <= slope_tolerance
                            # Between the ends of two solids that face each other the surface
                            # would have to bend inwards.
                            and back - slope <= max_dent * value[y, x] / focal
                        )
                        if best[b] == 0:
                            landed[hits] = b
                            hits += 1
                        best[b] = max(best[b], 2 if good else 1)
                        break
            for k in range(hits):
                b = landed[k]
                votes[a, b, 0] += 1
                if best[b] == 2:
                    votes[a, b, 1] += 1
                best[b] = 0
    return votes
