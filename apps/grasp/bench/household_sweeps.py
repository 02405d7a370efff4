"""Sweeps of single household objects that are slippery, unbalanced, hidden or on a soft floor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from eyehand.data_synth.cell import GraspCell
from eyehand.data_synth.scenes import MeshObject
from eyehand.grasping import PickOptions
from eyehand.perception import DepthFrame

from ...bench.sweep import Sweep, Trial
from ..mesh_scenes import ObjectSource, mesh_scene
from .camera_sweeps import change_frames
from .stress_trial import StressCell, stress_cell

PUT_AWAY = "in the tray at the end"
DENSITY = 400.0
"""Density of all objects, kg/m³. The masses in files are often placeholders."""
FALL_SECONDS = 1.0
"""Time in which an object comes to rest on the table, s."""
GRAVITY = 9.81
"""Gravitational acceleration, m/s²."""
SPRING_SHARE = 0.5
"""Impedance of a soft floor."""
SHARED_SINK = 8.0
"""Ratio of gravity / stiffness to the measured sink of a box, whose contacts share the weight."""
MIN_HEIGHT = 0.004
"""Height above the table from which a pixel belongs to the object, m."""

Change = Callable[[StressCell, MeshObject, float], None]


def household_sweeps(folder: str) -> tuple[Sweep[PickOptions], ...]:
    """Return the sweeps over the objects of a folder, one random object per trial.

    Perception runs on one noisy depth image. Few trials do not resolve a bound, so none is
    required.
    """
    source = ObjectSource(folder, density=DENSITY)
    rows: tuple[tuple[str, str, str, tuple[float, ...], Change | None], ...] = (
        ("friction", "friction of the hand's pads", "", (1.0, 0.7, 0.5, 0.3, 0.2), None),
        ("balance", "offset of the centre of mass along the object, of half its length", "%",
         (0.0, 25.0, 50.0, 75.0), _shift_mass),
        ("hidden", "share of the object's pixels without a reading, from one side", "%",
         (0.0, 20.0, 40.0, 60.0, 80.0), _hide),
        ("soft-floor", "depth by which a box sinks into the floor by its weight", "mm",
         (0.1, 0.5, 1.0, 2.0, 4.0), _soften),
    )  # fmt: skip
    return tuple(
        Sweep(name, axis, unit, values, None, partial(_attempt, source, change), PUT_AWAY)
        for name, axis, unit, values, change in rows
    )


def _attempt(
    source: ObjectSource, change: Change | None, value: float, seed: int, options: PickOptions
) -> Trial:
    """Clear a table with one object. Without a change, the value is the friction of the pads."""
    (item,) = mesh_scene(source, "single", seed, 1)
    friction = value if change is None else 1.0
    stress = stress_cell([item], seed, options, friction=friction, known=False)
    if change is not None:
        change(stress, item, value)
    stress.cell.wait(FALL_SECONDS)
    return stress.clear().trial()


def _shift_mass(stress: StressCell, item: MeshObject, share_pct: float) -> None:
    """Move the centre of mass along the longest side of the object, as in a half-full bottle."""
    half = 0.5 * np.ptp(item.vertices, axis=0)
    shift = 0.01 * share_pct * half * (np.arange(3) == half.argmax())
    model = stress.robot.model
    model.body_ipos[model.body(item.name).id] += shift


def _hide(stress: StressCell, item: MeshObject, share_pct: float) -> None:
    """Remove the readings of the object on one side of the image."""
    cell = GraspCell()

    def hidden(frame: DepthFrame) -> DepthFrame:
        assert frame.T_world_camera is not None
        points = frame.T_world_camera.apply(frame.points().reshape(-1, 3).astype(np.float64))
        near = np.linalg.norm((points - stress.robot.object_pose(item.name).translation), axis=1)
        mask = (points[:, 2] > cell.table.height + MIN_HEIGHT) & (near < item.radius)
        mask = mask.reshape(frame.depth.shape) & frame.valid
        columns = np.nonzero(mask)[1]
        if not columns.size:
            return frame
        mask[:, int(np.percentile(columns, share_pct)) :] &= share_pct >= 100.0
        return replace(frame, depth=np.where(mask, 0.0, frame.depth).astype(frame.depth.dtype))

    change_frames(stress, hidden)


def _soften(stress: StressCell, item: MeshObject, sink_mm: float) -> None:
    """Make the contact of object and table a critically damped spring, as on a heap."""
    model = stress.robot.model
    table = model.geom("table").id
    stiffness = GRAVITY / (SHARED_SINK * 1e-3 * sink_mm)
    model.geom_solref[table] = -stiffness, -2.0 * np.sqrt(stiffness)
    model.geom_solimp[table, :2] = SPRING_SHARE
    model.geom_priority[table] = 1
