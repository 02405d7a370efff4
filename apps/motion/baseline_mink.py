"""The baseline in reaching: mink, a library for differential inverse kinematics on MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.data_synth import JOINT_SPEED, TOOL_SITE
from eyehand.data_synth.scenes import arm_spec, clearance_pairs
from eyehand.errors import DeviceError

from .reach_outcome import ReachOptions, ReachOutcome, run_reach

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.scenes import ReachingScene

SOLVER = "daqp"


@dataclass(frozen=True)
class MinkOptions:
    """Settings of the baseline, chosen for its success on seeds 0 to 119. Most hardly matter."""

    speed: float = 0.25
    """Cap on the tool's commanded speed, m/s."""
    rate: float = 4.0
    """Share of the tool's distance to the goal that is closed per second, below the cap, 1/s."""
    posture_cost: float = 1e-4
    """Weight of staying in the starting posture beside 1 for the tool's position."""
    damping: float = 1e-4
    """Weight of small joint steps; more is smoother and slower near singular postures."""
    margin: float = 0.010
    """Least distance it shall keep, m."""
    detection: float = 0.100
    """Distance from which on a pair is looked at, m."""
    relaxation: float = 0.0
    """Added to what a pair may lose in one cycle, m; below 0 it must part."""
    approach: float = 0.1
    """Share of the distance left above the margin that a pair may lose in one cycle; mink's own
    `gain` divides by the cycle's length once too often, which is undone here."""


def run_mink(
    scene: ReachingScene,
    options: MinkOptions | None = None,
    reach: ReachOptions | None = None,
) -> ReachOutcome:
    """Run a reaching scene with mink: position, faint posture, and all its limits.

    Joint ranges, joint speeds and all pairs of shapes that can touch are limits of its quadratic
    program, which daqp solves.

    Parameters
    ----------
    scene
        The scene.
    options
        mink's settings.
    reach
        ControlStep and time.

    Returns
    -------
    ReachOutcome
        The judgement; status `infeasible` when its program had no solution.

    Raises
    ------
    DeviceError
        If mink is not installed: only developers need it.
    """
    reach = reach or ReachOptions()
    return run_reach(scene, _MinkMethod(scene, options or MinkOptions(), reach.dt), reach)


class _MinkMethod:
    def __init__(self, scene: ReachingScene, options: MinkOptions, dt: float) -> None:
        mink = _import_mink()
        self._mink, self._options, self._dt, self._goal = mink, options, dt, scene.goal
        model = arm_spec(scene.obstacles).compile()
        self._configuration = mink.Configuration(model, q=scene.start)
        self._site = model.site(TOOL_SITE).id
        self._reach = mink.FrameTask(
            TOOL_SITE, "site", position_cost=1.0, orientation_cost=0.0, gain=options.rate * dt
        )
        posture = mink.PostureTask(model, cost=options.posture_cost, gain=options.rate * dt)
        posture.set_target(scene.start)
        self._tasks = [self._reach, posture]
        names = [model.joint(k).name for k in range(model.njnt)]
        speeds = dict(zip(names, model.numeric(JOINT_SPEED).data, strict=True))
        pairs = [([int(one)], [int(other)]) for one, other in clearance_pairs(model)]
        self._limits = [
            mink.ConfigurationLimit(model),
            mink.VelocityLimit(model, speeds),
            mink.CollisionAvoidanceLimit(
                model,
                pairs,
                gain=options.approach * dt,
                bound_relaxation=options.relaxation,
                minimum_distance_from_collisions=options.margin,
                collision_detection_distance=options.detection,
            ),
        ]

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        configuration, mink = self._configuration, self._mink
        configuration.update(q)
        tool = configuration.data.site_xpos[self._site]
        way = self._goal - tool
        # A target ahead on the straight line caps the speed; turned as the tool is, its error is
        # the way alone.
        fastest = self._options.speed / self._options.rate
        ahead = way * min(1.0, fastest / max(float(np.linalg.norm(way)), fastest))
        turn = mink.SO3.from_matrix(configuration.data.site_xmat[self._site].reshape(3, 3))
        self._reach.set_target(mink.SE3.from_rotation_and_translation(turn, tool + ahead))
        try:
            speed = mink.solve_ik(
                configuration,
                self._tasks,
                self._dt,
                SOLVER,
                damping=self._options.damping,
                limits=self._limits,
            )
        except mink.NoSolutionFound:
            return np.zeros_like(q), "infeasible"
        return speed, ""


def _import_mink() -> Any:
    try:
        import mink
    except ImportError as error:
        raise DeviceError(
            f"cannot run the baseline: {error.name or 'mink'} is not installed; install it with "
            "`uv sync` or `pip install mink --no-deps qpsolvers daqp`"
        ) from error
    return mink
