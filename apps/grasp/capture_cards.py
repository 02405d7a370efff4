"""HTML cards of the report: each shows a capture, the selected grasp, its phases and forces."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import cv2
import numpy as np

from ..bench.report_page import data_url, html_table
from ..scene_picture import colour_of
from .demo_table import stop_text
from .force_plot import pick_timeline
from .frame_crop import crop_to_objects
from .perceived_picture import perceived_picture
from .score_terms import SIZE_NOTE, score_html

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping import GraspPlan, PickReport
    from eyehand.perception import DepthFrame

    from .demo_record import Capture, DemoRecord

PICTURE_WIDTH = 960
"""Width of the embedded images, px: twice their displayed width."""
DEPTH_RANGE = (1.0, 96.0)
"""Percentiles of depth that the colours span. They exclude the floor far below the table."""
JPEG_QUALITY = 88
"""JPEG quality. Lines stay sharp, and a capture takes 150 kB."""


def capture_card(number: int, capture: Capture, record: DemoRecord) -> str:
    """Return the card of a capture with a pick."""
    pick = capture.pick
    assert pick is not None
    return (
        f'<section class="card" id="capture{number}"><div class="head"><h2>Pick {number}</h2>'
        f"<span>{object_cell(capture)}</span><span>{escape(pick.plan.name)}</span>"
        f'{outcome_pill(capture)}<span class="faint">{escape(pick.reason)}</span></div>'
        f"{_pictures(capture)}"
        '<div class="two"><div><h3>Tasks of the approach</h3>'
        f"{_task_table(pick)}</div><div><h3>Selected and rejected grasps</h3>"
        f"{_rejected(pick)}</div></div>"
        '<h3>Phases and contact forces</h3><div class="wide" tabindex="0" role="region" '
        f'aria-label="contact forces">{pick_timeline(pick, record.fingers)}</div>'
        f"{_numbers(capture)}</section>"
    )


def final_capture_card(number: int, capture: Capture, record: DemoRecord) -> str:
    """Return the card of a capture without a pick."""
    remaining = "".join(f"<li>{escape(line)}</li>" for line in record.report.remaining)
    title, about = "Last capture", stop_text(record.report)
    if number < len(record.captures):
        title, about, remaining = "Capture without a pick", "nothing was grasped", ""
    return (
        f'<section class="card" id="capture{number}"><div class="head"><h2>{title}</h2>'
        f'<span class="faint">{escape(about)}</span></div>{_pictures(capture)}'
        f"{f'<h3>Remaining objects</h3><ul>{remaining}</ul>' if remaining else ''}</section>"
    )


def object_cell(capture: Capture) -> str:
    """Return the cell of the picked object: its colour, the kind of its solid, its size."""
    item, pick = capture.target, capture.pick
    if item is None or pick is None:
        return "?"
    colour = ",".join(map(str, colour_of(capture.colours.get(item.label, item.label)).tolist()))
    solid = item.fit.superquadric
    size = "" if solid is None else " × ".join(f"{2e3 * a:.0f}" for a in solid.semi_axes)
    return (
        f'<span class="swatch" style="background:rgb({colour})"></span>{escape(pick.kind)} '
        f'<span class="faint" title="{escape(SIZE_NOTE, quote=True)}">{size} mm</span>'
    )


def outcome_pill(capture: Capture) -> str:
    """Return the outcome as a coloured label."""
    bad = "" if capture.succeeded else " bad"
    return f'<span class="pill{bad}">{escape(capture.outcome)}</span>'


def _pictures(capture: Capture) -> str:
    frame, scene = crop_to_objects(capture.frame, capture.scene)
    plan = None if capture.pick is None else capture.pick.plan
    overlay = perceived_picture(frame, scene, plan, capture.T_world_palm, colours=capture.colours)
    caption = "segments, fitted solids and the grasp"
    if capture.pick is None:
        caption = "the perceived scene"
    elif capture.T_world_palm is None:
        caption += " as planned"
    else:
        caption += " at the closing pose"
    key = (
        '<span class="key" style="background:#fff"></span>palm and fingers'
        '<span class="key" style="background:#ffb000"></span>thumb'
    )
    return (
        '<div class="pictures">'
        f'<figure><img alt="depth image" src="{_picture_url(_depth_image(frame))}">'
        "<figcaption>noisy depth image: near yellow, far blue, no reading black"
        "</figcaption>"
        f'</figure><figure><img alt="{caption}" src="{_picture_url(overlay)}"><figcaption>{caption}'
        f"{'' if capture.pick is None else ';' + key}</figcaption></figure></div>"
    )


def _depth_image(frame: DepthFrame) -> NDArray[np.uint8]:
    """Colour depth from near (yellow) to far (blue), (H, W, 3) uint8 RGB. No reading is black."""
    near, far = np.percentile(frame.depth[frame.valid], DEPTH_RANGE)
    shade = np.clip((far - frame.depth) / max(float(far - near), 1e-6), 0.0, 1.0)
    coloured = cv2.applyColorMap((255 * shade).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    return np.where(frame.valid[..., None], np.asarray(coloured)[..., ::-1], 0).astype(np.uint8)


def _picture_url(picture: NDArray[np.uint8]) -> str:
    """Return a scaled JPEG image as a data URL."""
    height, width = picture.shape[:2]
    how = cv2.INTER_AREA if width > PICTURE_WIDTH else cv2.INTER_CUBIC
    size = (PICTURE_WIDTH, round(height * PICTURE_WIDTH / width))
    scaled = np.ascontiguousarray(cv2.resize(picture, size, interpolation=how)[..., ::-1])
    _, encoded = cv2.imencode(".jpg", scaled, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return data_url(encoded.tobytes(), "image/jpeg")


def _task_table(pick: PickReport) -> str:
    rows = [
        [escape(task.name.replace("_", " ")), str(task.rows or "bounds"), escape(task.description)]
        for task in pick.plan.tasks
    ]
    note = '<span class="faint">of the 6 that a full pose takes</span>'
    rows.append(["<b>total</b>", f"<b>{pick.plan.rows}</b>", note])
    return html_table(["task", "rows", "meaning"], rows, numbers=(1,))


def _rejected(pick: PickReport) -> str:
    plan = pick.plan
    chosen = f"<dt><b>{escape(plan.name)}</b></dt><dd>"
    chosen += f'<span title="{escape(SIZE_NOTE, quote=True)}">{escape(_grasp_size(plan))}</span>'
    terms = score_html(plan.score.terms)
    if terms:
        chosen += f'<br><span class="faint">score {plan.score.total:.2f} = {terms}</span>'
    chosen += "</dd>"
    others = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(why)}</dd>" for name, why in plan.rejected.items()
    )
    return f"<dl>{chosen}{others}</dl>"


def _grasp_size(plan: GraspPlan) -> str:
    """Describe the size of the object at the grasp."""
    geometry = plan.geometry
    if geometry is None:
        return plan.reason
    sides = f"{1e3 * geometry.width:.0f} mm wide × {1e3 * geometry.length:.0f} mm long"
    return f"between the fingers: {sides}, {1e3 * geometry.height:.0f} mm high"


def _numbers(capture: Capture) -> str:
    pick, row = capture.pick, capture.row
    assert pick is not None
    figures = [
        (f"{pick.perceive_ms:.0f} ms", "to perceive"),
        (f"{pick.plan_ms:.0f} ms", "to select and plan"),
        (f"{pick.seconds:.2f} s", "simulated"),
    ]
    if len(pick.forces):
        figures.append((f"{pick.forces.max():.1f} N", "largest force on a finger or the palm"))
    if pick.contact_pads:
        pads, curl = pick.contact_pads, pick.finger_curl
        figures.append(
            (f"{pads} pads", f"in contact while held, fingers bent {np.degrees(curl):.0f}°")
        )
    if row is not None and row.touched_before:
        figures.append((str(row.touched_before), "other bodies touched before the grasp"))
    if row is not None and row.success != bool(pick):
        place = "is in the tray" if row.success else "is not in the tray"
        figures.append(("Ground truth", f"the object {place}"))
    failed = [record for record in pick.phases if record.outcome != "done"]
    figures += [(record.phase, record.outcome) for record in failed]
    spans = "".join(f"<span><b>{escape(a)}</b> {escape(b)}</span>" for a, b in figures)
    return f'<div class="numbers">{spans}</div>'
