"""Control tasks of a grasp plan: the arm that follows them reaches the planned palm pose."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import ApproachController, CollisionWorld, ControlOptions, RobotModel
from eyehand.control.tasks import PointOnPlane
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.errors import InputError
from eyehand.grasping import plan_prototypes
from eyehand.grasping.control_tasks import control_tasks
from eyehand.grasping.hands import nominal_hand
from eyehand.grasping.palm_placement import EDGE_GAP, MAX_SPHERE_TILT, TABLE_GAP, max_closing_reach
from eyehand.perception import SceneObject, Superquadric, SuperquadricFit, SupportPlane

TABLE = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)
RETREAT_M = 0.08
HAND = nominal_hand()
PERIOD = 0.02
# The arm of these tests has no hand and no obstacles: only the tasks are tested.
OPTIONS = ControlOptions(dt=PERIOD, eta=1.0, retreats=0)


def standing_object(kind, axes, e, turn=(0.0, 0.0, 0.0), at=(0.55, 0.05)) -> SceneObject:
    rotation = Rotation.from_rotvec(turn)
    high = np.abs(rotation.as_matrix()[2]) @ axes if kind in ("box", "cylinder") else axes[2]
    pose = RigidTransform.from_components([*at, high], rotation)
    solid = Superquadric(np.array(axes), e, pose, kind)
    return SceneObject(
        1, np.zeros((0, 3)), 900, SuperquadricFit(solid, True, "", np.zeros(9), (), 0.0), 1.0, 0
    )


BALL = standing_object("sphere", [0.0375] * 3, (1.0, 1.0))
SMALL_BALL = standing_object("sphere", [0.012] * 3, (1.0, 1.0))
CAN = standing_object("cylinder", [0.03, 0.03, 0.08], (0.1, 1.0))
JAR = standing_object("cylinder", [0.0375, 0.0375, 0.04], (0.1, 1.0))
STICK = standing_object("cylinder", [0.02, 0.02, 0.07], (0.1, 1.0), turn=(0.0, np.pi / 2, 0.0))
CARTON = standing_object("box", [0.045, 0.03, 0.10], (0.1, 0.1), turn=(0.0, 0.0, 0.4))
BRICK = standing_object("box", [0.05, 0.022, 0.015], (0.1, 0.1), turn=(0.0, 0.0, -0.7))
EGG = standing_object("ellipsoid", [0.045, 0.03, 0.03], (1.0, 1.0), turn=(0.0, 0.0, 1.0))


@pytest.fixture(scope="module")
def world() -> CollisionWorld:
    return CollisionWorld(RobotModel.load(LBR_ARM, TOOL_SITE))


def follow(world, item, name, q=None):
    """Return the best reachable grasp of a name, and the tool's states before and at it."""
    for plan in plan_prototypes(item, TABLE):
        states = _states(world, plan, q) if plan.name == name else ()
        if len(states) == 2:
            return plan, *states
    raise AssertionError(f"no {name} was reached")


def _states(world, plan, q):
    q = world.robot.home if q is None else q
    states = []
    for retreat in (RETREAT_M, 0.0):
        controller = ApproachController(world, control_tasks(plan, HAND, retreat), OPTIONS)
        status = "moving"
        for _ in range(700):
            cycle = controller.step(q)
            status = cycle.status
            if status != "moving":
                break
            q = q + PERIOD * cycle.velocity
        if status != "reached":
            break
        states.append(world.robot.at(q))
    return states


def plan_of(item, name):
    return next(plan for plan in plan_prototypes(item, TABLE) if plan.name == name)


@pytest.mark.parametrize(
    ("item", "name"),
    [
        (BALL, "top power"),
        (SMALL_BALL, "top pincer"),
        (CAN, "side power"),
        (CAN, "top precision"),
        (JAR, "top power"),
        (STICK, "top precision"),
        (CARTON, "side power"),
        (BRICK, "top precision"),
        (EGG, "top precision"),
    ],
)
def test_palm_reaches_retreat_pose_then_grasp_pose(world, item, name):
    plan, retreated, reached = follow(world, item, name)
    grip = plan.geometry
    assert grip is not None
    centre, x, palm = grip.centre, reached.rotation[:, 0], reached.rotation[:, 2]
    to_centre = centre - reached.position
    # The object lies on the palm's axis, but for the interval along its length or height.
    along = grip.up if plan.approach == "side" else reached.rotation[:, 1]
    off = to_centre - (to_centre @ palm) * palm
    assert np.linalg.norm(off - (off @ along) * along) < 2e-3
    assert abs(off @ along) < 0.016 + 2e-3
    assert to_centre @ palm == pytest.approx(plan.standoff, abs=2e-3)
    assert (centre - retreated.position) @ retreated.rotation[:, 2] == pytest.approx(
        plan.standoff + RETREAT_M, abs=2e-3
    )
    if plan.approach == "top":
        assert palm @ grip.up < -np.cos(MAX_SPHERE_TILT + 0.01)
        tips = reached.position[2] + max_closing_reach(HAND, grip.width, plan.opening) * palm[2]
        lean = 0.5 * HAND.outer_width(plan.opening) * np.linalg.norm(palm[:2])
        assert tips - lean > TABLE_GAP - 3e-3
    else:
        assert abs(palm @ grip.up) < 3e-3
        assert abs(reached.rotation[2, 1]) > 1 - 1e-4
        assert reached.position[2] - 0.5 * HAND.row_width > EDGE_GAP - 2e-3
    if grip.freedom == "none":
        assert x @ plan.closing > 1 - 1e-4


@pytest.mark.parametrize(
    ("item", "name", "free"),
    [(BALL, "top power", "turn"), (JAR, "top power", "turn"), (CAN, "side power", "side")],
)
def test_free_rotation_depends_on_start_posture(world, item, name, free):
    ends = []
    for turn in (-0.5, 0.5):
        q = world.robot.home.copy()
        q[0] += turn
        q[6] += 2.0 * turn
        *_, reached = follow(world, item, name, q)
        ends.append(reached.rotation[:, 2 if free == "side" else 0])
    assert ends[0] @ ends[1] < np.cos(0.2)


def test_task_types_do_not_depend_on_retreat():
    for item in (BALL, CAN, CARTON, BRICK):
        for plan in plan_prototypes(item, TABLE):
            kinds = [
                [
                    (type(task), type(getattr(task, "task", None)))
                    for task in control_tasks(plan, HAND, retreat)
                ]
                for retreat in (0.0, 0.2)
            ]
            assert kinds[0] == kinds[1]
            assert len(kinds[0]) == len(plan.tasks)


def test_control_tasks_follow_shifted_plan_tasks():
    plan = plan_of(CARTON, "side power")
    off = np.array([0.004, -0.003, 0.0])
    moved = replace(plan, tasks=tuple(replace(t, point=t.point + off) for t in plan.tasks))
    for task, reached in zip(control_tasks(plan, HAND), control_tasks(moved, HAND), strict=True):
        if isinstance(task, PointOnPlane):
            assert isinstance(reached, PointOnPlane)
            assert reached.offset - task.offset == pytest.approx(task.normal @ off)


def test_rejected_plan_and_negative_retreat_raise():
    (plan,) = plan_prototypes(standing_object("box", [0.2, 0.2, 0.1], (0.1, 0.1)), TABLE)
    with pytest.raises(InputError, match="refused"):
        control_tasks(plan, HAND)
    with pytest.raises(InputError, match="retreat"):
        control_tasks(plan_of(BALL, "top power"), HAND, -0.1)
