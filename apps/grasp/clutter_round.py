"""One round of the public clutter-removal protocol: perceive, plan and grasp until a round ends.

The protocol is that of VGN (Breyer et al., CoRL 2020) and GIGA (Jiang et al., RSS 2021), by GIGA's
code. What differs from the original:

- Physics is MuJoCo at 2 ms instead of PyBullet at 4.2 ms. Friction is 1 for all pairs, as there.
  Torsional friction is 0.01 m; the original's pads have 0.1.
- The hand is made of the boxes of its description. Its base is a servo with at most 300 N that does
  not turn. The pads close at 0.2 m/s with 20 N each.
- A contact counts from a penetration of 0.01 mm. PyBullet also reports points close to contact.
- Objects stand with their lowest point 2 mm above the table. The original centres bounding boxes.
- The table is infinite, depth ends at 2 m, and pixels without a reading are 0.
- The object that most contacts belong to is taken away. The original takes that of the first one.

The hand always opens fully, as there, whatever the planner proposes.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.cell import (
    CAMERA,
    MAX_RANGE,
    ClutterFamily,
    ClutterWorld,
    camera_pose,
    execute_grasp,
    make_clutter,
)
from eyehand.data_synth.render import add_dex_noise, open_renderer
from eyehand.data_synth.scenes import PieceObject, Split, read_piece_objects, select_half
from eyehand.grasping import (
    Grasp,
    JawOptions,
    SupportMemory,
    correct_depth,
    load_hand,
    plan_grasps,
)
from eyehand.perception import DepthFrame, PerceiveOptions, perceive

from .grasp_failure import failure_cause, is_heavy, segment_truth

Noise = Literal["none", "dex"]
MAX_FAILURES = 2
"""Number of successive failures that ends a round."""
FORCE = 20.0
"""Closing force of each finger, N, as in the original."""
TABLE_HEIGHT = 0.0
"""Height of the table in the world, m."""


@dataclass(frozen=True)
class Changes:
    """The changes of a round to the protocol."""

    calibration_error: float = 0.0
    """Distance of the hand from the planned place, m, in a random direction for each grasp."""
    calibration_angle: float = 0.0
    """Angle by which it is turned about its tool centre point, rad, about a random axis."""
    friction: float = 1.0
    """Coulomb friction of all pairs."""
    mass_factor: float = 1.0
    """Factor of the objects' masses."""
    camera_turned: float = 0.0
    """Angle by which the line of sight is nearer to the vertical, rad."""
    noise_scale: float = 1.0
    """Factor of the depth noise."""


@dataclass(frozen=True)
class ClutterTrial:
    """One round."""

    family: ClutterFamily
    """Arrangement of the objects."""
    seed: int
    """Seed of the scene and of the noise."""
    objects: str
    """Folder of the objects."""
    noise: Noise = "none"
    """Noise of the depth image."""
    known_table: bool = False
    """Whether scale and tilt of the image are corrected from the known height of the table."""
    learned_table: bool = False
    """Whether the images of a round are scaled to the mean height of the table in them."""
    safe_only: bool = False
    """Whether only safe grasps are executed. A round ends when there is none."""
    hand: str = "panda"
    """Name or file of the hand."""
    split: Split = "all"
    """Which objects are drawn."""
    density: float | None = None
    """Mass over volume of the objects, kg/m³; None for the masses of the files."""
    count: int = 5
    """Number of objects."""
    changes: Changes = Changes()
    """What differs from the protocol."""
    planner: Mapping[str, Any] = field(default_factory=dict)
    """Other values of `JawOptions`, by field name."""
    max_attempts: int | None = None
    """Number of grasps after which the round ends; None for no limit."""


@dataclass(frozen=True)
class Attempt:
    """One grasp of a round."""

    object: str
    """True object of the grasp."""
    mass: float
    """Its mass, kg."""
    success: bool
    """Whether it was removed."""
    predicted: float
    """Probability that the planner gave."""
    safe: bool
    """Whether the planner called it safe."""
    cause: str
    """Cause of the failure, or an empty string."""
    perceive_ms: float
    """Processor time of perception on one thread, ms."""
    plan_ms: float
    """Processor time of planning on one thread, ms."""
    objects_seen: int
    """Number of objects that were perceived."""
    heavy: bool
    """Whether the object weighs more than the hand can be expected to hold."""


def run_clutter_round(trial: dict[str, Any]) -> dict[str, Any]:
    """Run a round, and return its attempts and counts as plain numbers and text."""
    changes = Changes(**trial.get("changes", {}))
    settings = ClutterTrial(**{**trial, "changes": changes})
    objects = [
        replace(item, mass=changes.mass_factor * item.mass)
        for item in _objects(settings.objects, settings.split, settings.density)
    ]
    hand = load_hand(settings.hand)
    rng = np.random.default_rng([settings.seed, len(settings.family)])
    world = make_clutter(
        settings.family,
        objects,
        hand,
        rng,
        count=settings.count,
        force=FORCE,
        friction=changes.friction,
    )
    placed = world.count
    heavy = sorted(
        world.objects[k].name for k in world.placed if is_heavy(world.objects[k].mass, FORCE)
    )
    attempts: list[Attempt] = []
    failed: tuple[Grasp, ...] = ()
    memory = SupportMemory(JawOptions().depth_error) if settings.learned_table else None
    failures, ended = 0, "cleared"
    while world.count:
        if len(attempts) == settings.max_attempts:
            ended = "attempts"
            break
        attempt, grasp, reason = _attempt(world, settings, failed, rng, memory)
        if attempt is None or grasp is None:
            ended = f"no grasp: {reason}"
            break
        attempts.append(attempt)
        if attempt.success:
            failures = 0
            continue
        failures += 1
        failed = (*failed, grasp)
        if failures == MAX_FAILURES:
            ended = "two failures"
            break
    return {
        "placed": placed,
        "heavy": heavy,
        "removed": sum(attempt.success for attempt in attempts),
        "left": [world.objects[k].name for k in sorted(world.placed)],
        "ended": ended,
        "attempts": [asdict(attempt) for attempt in attempts],
    }


def clutter_objects(
    folder: str, split: Split, density: float | None = None
) -> tuple[PieceObject, ...]:
    """Return the objects of a folder, all or a half by their names.

    Raises
    ------
    InputError
        If the folder cannot be read, the half is empty, or the density is not positive.
    """
    found = read_piece_objects(folder, density)
    return select_half(found, [item.name for item in found], split)


_objects = cache(clutter_objects)


def _attempt(
    world: ClutterWorld,
    settings: ClutterTrial,
    failed: tuple[Grasp, ...],
    rng: np.random.Generator,
    memory: SupportMemory | None,
) -> tuple[Attempt | None, Grasp | None, str]:
    """Look, plan and grasp once."""
    T_world_camera = camera_pose(settings.changes.camera_turned)
    view = open_renderer().render(
        world.model,
        world.data,
        CAMERA,
        T_world_camera,
        world.labels,
        max_range=MAX_RANGE,
        colour=False,
    )
    depth = view.depth
    if settings.noise == "dex":
        noise = add_dex_noise(view.depth, rng) - view.depth
        depth = np.maximum(depth + np.float32(settings.changes.noise_scale) * noise, 0.0)
    frame = DepthFrame(depth, CAMERA, T_world_camera)
    started = time.thread_time()
    if settings.known_table:
        frame, _ = correct_depth(frame, TABLE_HEIGHT)
    if memory is not None:
        frame, _ = memory.corrected(frame)
    scene = perceive(frame, PerceiveOptions(threads=1))
    perceived = time.thread_time()
    grasps = plan_grasps(scene, world.hand, _options(settings, failed))
    planned = time.thread_time()
    offered = [grasp for grasp in grasps if grasp.safe or not settings.safe_only]
    if not offered:
        return None, None, grasps.reason
    grasp = offered[0]
    truth = segment_truth(scene, grasp, view.labels, world)
    course = execute_grasp(world, _misplaced(grasp, settings, len(failed)))
    world.rest_and_remove()
    cause = "" if course.success else failure_cause(course, truth, grasp, FORCE)
    attempt = Attempt(
        object=truth.name,
        mass=truth.mass,
        success=course.success,
        predicted=grasp.success,
        safe=grasp.safe,
        cause=cause,
        perceive_ms=1e3 * (perceived - started),
        plan_ms=1e3 * (planned - perceived),
        objects_seen=len(scene.objects),
        heavy=is_heavy(truth.mass, FORCE),
    )
    return attempt, grasp, ""


def _misplaced(grasp: Grasp, settings: ClutterTrial, number: int) -> RigidTransform:
    """Return the pose of the hand with the calibration error."""
    changes = settings.changes
    rng = np.random.default_rng([settings.seed, number, 17])
    shift, axis = (one / np.linalg.norm(one) for one in rng.standard_normal((2, 3)))
    turn = Rotation.from_rotvec(changes.calibration_angle * axis)
    return RigidTransform.from_components(
        grasp.position + changes.calibration_error * shift, turn * grasp.T_scene_tcp.rotation
    )


def _options(settings: ClutterTrial, failed: tuple[Grasp, ...]) -> JawOptions:
    calibration = max(settings.changes.calibration_error, JawOptions().calibration_error)
    # Several rounds run at the same time, and the times of one thread are reported.
    options = JawOptions(
        full_opening=True, guarded=True, failed=failed, calibration_error=calibration, threads=1
    )
    return replace(options, **settings.planner)
