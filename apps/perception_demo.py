"""`eyehand demo --perception-only`: perceive a synthetic and a real frame."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame
from eyehand.errors import InputError
from eyehand.grasping import GraspOptions, GraspPurpose
from eyehand.perception import DepthFrame, read_frame

from .console import print_json, say, show
from .output_files import write_perceived_frame, write_picture
from .perceived_frame import PerceivedFrame, check_usable, load_kernels, perceive_and_plan
from .run_folder import claim_folder
from .scene_picture import depth_picture, overlay_picture
from .scene_table import scene_rows, scene_table
from .segmentation.score import SegmentationScore, score_segmentation
from .synth import MAX_OBJECTS

SAMPLE = Path(__file__).parent / "sample" / "depth.png"
"""Sample frame in the package, made by `eyehand synth`."""
REAL_FRAME = Path("frames/pcl/milk_cartoon_all_small_clorox.pcd")
"""Path of the real frame in the folder of test data."""
PANEL_HEIGHT = 720
GAP = 12


@dataclass(frozen=True)
class _Shown:
    name: str
    source: str
    found: PerceivedFrame
    score: SegmentationScore | None


def perception_demo(
    frame: Path | None,
    camera: Path | None,
    *,
    seed: int,
    objects: int,
    purpose: GraspPurpose,
    out: Path,
    json: bool,
) -> int:
    """Perceive a synthetic scene with known truth and a real frame, and write their pictures.

    Parameters
    ----------
    frame, camera
        Your own depth frame in place of the real one, and its camera file.
    seed, objects
        Seed and number of objects of the synthetic scene.
    purpose
        What the objects are grasped for.
    out
        Output folder.
    json
        Print one JSON object on stdout; tables go to stderr.

    Raises
    ------
    InputError
        If the number of objects is out of range or the frame cannot be read.
    """
    if not 1 <= objects <= MAX_OBJECTS:
        raise InputError(f"--objects must be 1 to {MAX_OBJECTS}, got {objects}")
    # The real frame comes first because reading it can fail.
    real, name, source = _real_frame(frame, camera)
    claim_folder(out)
    say("making a synthetic scene: physics, camera, depth noise ...")
    scene = make_scene(seed, TabletopOptions(count_range=(objects, objects)))
    synthetic, truth = render_frame(scene, DepthNoise.realistic(), seed)
    load_kernels()
    select = GraspOptions(purpose=purpose)
    found = perceive_and_plan(synthetic, select)
    score = score_segmentation(found.scene.segmentation.labels, truth)
    perceived = perceive_and_plan(real, select)
    if frame is not None:
        check_usable(perceived.scene.segmentation, source)
    shown = [
        _Shown("synthetic", f"synthetic scene, seed {seed}", found, score),
        _Shown(name, source, perceived, None),
    ]
    rows = []
    for item in shown:
        write_perceived_frame(out / item.name, item.found, item.source)
        show(scene_table(item.found, item.source), json_wanted=json)
        if item.score is not None:
            say(_against_truth(item.score))
        rows += scene_rows(item.found, item.name)
    overview = out / "overview.png"
    write_picture(overview, _stacked([_panel(item.found) for item in shown]))
    say(f"pictures: {overview}; overlay.png, labels.png, scene.json per frame in {out}")
    if json:
        print_json("demo", seed, rows, out=str(out), overlap_f_pct=round(100 * score.f, 2))
    return 0


def _real_frame(path: Path | None, camera: Path | None) -> tuple[DepthFrame, str, str]:
    """Read the given frame, else the real one of the test data, else the sample of the package.

    Returns
    -------
    DepthFrame, str, str
        The frame, the name of its folder, and its source.
    """
    if path is not None:
        return read_frame(path, camera), "real", str(path)
    data = Path(os.environ.get("EYEHAND_DATA", "../shared/data"))
    if (data / REAL_FRAME).is_file():
        return read_frame(data / REAL_FRAME), "real", f"real frame {REAL_FRAME.name}"
    say(f"no real frame at {data / REAL_FRAME}: showing the synthetic sample instead")
    return read_frame(SAMPLE), "sample", "synthetic sample frame of the package"


def _against_truth(score: SegmentationScore) -> str:
    return (
        f"against the truth: {score.predicted_count} of {score.truth_count} objects, "
        f"overlap F {100 * score.f:.1f} %"
    )


def _stacked(panels: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Stack panels vertically and pad the narrower ones with white."""
    width = max(panel.shape[1] for panel in panels)
    return np.vstack(
        [
            np.pad(panel, ((0, 0), (0, width - panel.shape[1]), (0, 0)), constant_values=255)
            for panel in panels
        ]
    )


def _panel(found: PerceivedFrame) -> NDArray[np.uint8]:
    """Draw the depth image on the left and the perceived scene on the right."""
    pictures = [depth_picture(found.frame), overlay_picture(found.frame, found.scene, found.plans)]
    scaled = []
    for picture in pictures:
        width = round(picture.shape[1] * PANEL_HEIGHT / picture.shape[0])
        shrinks = picture.shape[0] > PANEL_HEIGHT
        how = cv2.INTER_AREA if shrinks else cv2.INTER_CUBIC
        resized = cv2.resize(picture, (width, PANEL_HEIGHT), interpolation=how)
        scaled.append(np.asarray(resized, dtype=np.uint8))
    gap = np.full((PANEL_HEIGHT, GAP, 3), 255, np.uint8)
    row = np.hstack([scaled[0], gap, scaled[1]])
    return np.vstack([row, np.full((GAP, row.shape[1], 3), 255, np.uint8)])
