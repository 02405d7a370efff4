"""A look and its pick as a card of the demo's page: pictures, choice, phases, forces."""

from __future__ import annotations

import base64
from html import escape
from typing import TYPE_CHECKING

import cv2
import numpy as np

from ..scene_picture import colour_of
from .force_plot import pick_timeline
from .frame_crop import closeup
from .perceived_picture import look_picture
from .score_terms import SIZES, score_words

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping import GraspPlan, PickReport
    from eyehand.perception import DepthFrame

    from .demo_record import DemoRecord, Look

PICTURE_WIDTH = 960
"""Of the pictures in the page, px: twice what it shows them at."""
DEPTH_RANGE = (1.0, 96.0)
"""Percentiles of depth that the colours span: what is far beyond the table would take them all."""
QUALITY = 88
"""JPEG quality: lines stay clean, and a look takes 150 kB."""


def look_card(number: int, look: Look, record: DemoRecord) -> str:
    """Make the card of a look that a pick followed."""
    pick = look.pick
    assert pick is not None
    return (
        f'<section class="card" id="look{number}"><div class="head"><h2>Pick {number}</h2>'
        f"<span>{object_cell(look)}</span><span>{escape(pick.plan.name)}</span>"
        f"{outcome_pill(look)}{_why(pick)}</div>"
        f"{_pictures(look)}"
        '<div class="two"><div><h3>What the approach controls</h3>'
        f"{_task_table(pick)}</div><div><h3>Why this grasp and no other</h3>"
        f"{_rejected(pick)}</div></div>"
        f"<h3>Phases and touch</h3>{pick_timeline(pick, record.fingers)}{_numbers(look)}</section>"
    )


def final_look_card(number: int, look: Look, record: DemoRecord) -> str:
    """Make the card of a look after which nothing was picked."""
    left = "".join(f"<li>{escape(one)}</li>" for one in record.report.remaining)
    stopped = record.report.stop_reason
    told = "nothing is left on the table" if stopped == "clear" else stopped
    return (
        f'<section class="card" id="look{number}"><div class="head"><h2>Last look</h2>'
        f'<span class="faint">{escape(told)}</span></div>{_pictures(look)}'
        f"{f'<h3>Left alone</h3><ul>{left}</ul>' if left else ''}</section>"
    )


def object_cell(look: Look) -> str:
    """Name what was picked: its colour in the pictures, its solid, its size."""
    item, pick = look.target, look.pick
    if item is None or pick is None:
        return "?"
    colour = ",".join(map(str, colour_of(look.colours.get(item.label, item.label)).tolist()))
    solid = item.fit.superquadric
    size = "" if solid is None else " × ".join(f"{2e3 * a:.0f}" for a in solid.semi_axes)
    return (
        f'<span class="swatch" style="background:rgb({colour})"></span>{escape(pick.kind)} '
        f'<span class="faint" title="{escape(SIZES, quote=True)}">{size} mm</span>'
    )


def outcome_pill(look: Look) -> str:
    """Give the outcome as a coloured word, and what the truth says against it."""
    bad = "" if look.went_well else " bad"
    return f'<span class="pill{bad}">{escape(look.outcome)}</span>'


def _why(pick: PickReport) -> str:
    return f'<span class="faint">{escape(pick.reason)}</span>' if pick.reason else ""


def _pictures(look: Look) -> str:
    frame, scene = closeup(look.frame, look.scene)
    plan = None if look.pick is None else look.pick.plan
    overlay = look_picture(frame, scene, plan, look.T_world_palm, colours=look.colours)
    told = "segments, fitted solids and the grasp"
    if look.pick is None:
        told = "what was seen on the table"
    elif look.T_world_palm is None:
        told += " that was planned"
    else:
        told += " where the hand closed"
    key = (
        '<span class="key" style="background:#fff"></span>palm and fingers'
        '<span class="key" style="background:#ffb000"></span>thumb'
    )
    return (
        '<div class="pictures">'
        f'<figure><img alt="depth image" src="{_embedded(_depth(frame))}">'
        "<figcaption>depth with the camera's noise: near yellow, far blue, no reading black"
        "</figcaption>"
        f'</figure><figure><img alt="{told}" src="{_embedded(overlay)}"><figcaption>{told}'
        f"{'' if look.pick is None else ';' + key}</figcaption></figure></div>"
    )


def _depth(frame: DepthFrame) -> NDArray[np.uint8]:
    """Colour depth from near (yellow) to far (blue), no reading black, (H, W, 3) uint8 RGB."""
    near, far = np.percentile(frame.depth[frame.valid], DEPTH_RANGE)
    shade = np.clip((far - frame.depth) / max(float(far - near), 1e-6), 0.0, 1.0)
    coloured = cv2.applyColorMap((255 * shade).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    return np.where(frame.valid[..., None], np.asarray(coloured)[..., ::-1], 0).astype(np.uint8)


def _embedded(picture: NDArray[np.uint8]) -> str:
    """Give a picture as an address that holds it."""
    height, width = picture.shape[:2]
    how = cv2.INTER_AREA if width > PICTURE_WIDTH else cv2.INTER_CUBIC
    size = (PICTURE_WIDTH, round(height * PICTURE_WIDTH / width))
    scaled = np.ascontiguousarray(cv2.resize(picture, size, interpolation=how)[..., ::-1])
    _, encoded = cv2.imencode(".jpg", scaled, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return f"data:image/jpeg;base64,{base64.b64encode(encoded.tobytes()).decode()}"


def _task_table(pick: PickReport) -> str:
    rows = "".join(
        f"<tr><td>{escape(task.name.replace('_', ' '))}</td>"
        f'<td class="n">{task.rows or "bounds"}</td><td>{escape(task.description)}</td></tr>'
        for task in pick.plan.tasks
    )
    return (
        '<table><thead><tr><th>task</th><th class="n">rows</th><th>it asks</th></tr></thead>'
        f"<tbody>{rows}<tr><td><b>together</b></td>"
        f'<td class="n"><b>{pick.plan.rows}</b></td><td class="faint">of the 6 that a full pose '
        "takes</td></tr></tbody></table>"
    )


def _rejected(pick: PickReport) -> str:
    plan = pick.plan
    chosen = f"<dt><b>{escape(plan.name)}</b></dt><dd>"
    chosen += f'<span title="{escape(SIZES, quote=True)}">{escape(_as_met(plan))}</span>'
    terms = score_words(plan.score.terms)
    if terms:
        chosen += f'<br><span class="faint">score {plan.score.total:.2f} = {terms}</span>'
    chosen += "</dd>"
    others = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(why)}</dd>" for name, why in plan.rejected.items()
    )
    return f"<dl>{chosen}{others}</dl>"


def _as_met(plan: GraspPlan) -> str:
    """Say how large the object is for the hand, where it has a hold."""
    geometry = plan.geometry
    if geometry is None:
        return plan.reason
    sides = f"{1e3 * geometry.width:.0f} mm wide × {1e3 * geometry.length:.0f} mm long"
    return f"between the fingers: {sides}, {1e3 * geometry.height:.0f} mm high"


def _numbers(look: Look) -> str:
    pick, row = look.pick, look.row
    assert pick is not None
    told = [
        (f"{pick.perceive_ms:.0f} ms", "to perceive"),
        (f"{pick.plan_ms:.0f} ms", "to choose and plan"),
        (f"{pick.seconds:.2f} s", "simulated"),
    ]
    if len(pick.forces):
        told.append((f"{pick.forces.max():.1f} N", "largest force on a finger or the palm"))
    if pick.contact_pads:
        pads, curl = pick.contact_pads, pick.finger_curl
        told.append((f"{pads} pads", f"in contact when held, fingers bent {np.degrees(curl):.0f}°"))
    if row is not None and row.touched_before:
        told.append((str(row.touched_before), "other things touched before the grasp"))
    if row is not None and row.success != bool(pick):
        said = "is in the tray" if row.success else "is not in the tray"
        told.append(("By the simulation's truth", f"the object {said}"))
    wrong = [record for record in pick.phases if record.outcome != "done"]
    told += [(record.phase, record.outcome) for record in wrong]
    spans = "".join(f"<span><b>{escape(a)}</b> {escape(b)}</span>" for a, b in told)
    return f'<div class="numbers">{spans}</div>'
