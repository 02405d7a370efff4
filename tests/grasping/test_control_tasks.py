"""An arm that follows a plan's tasks ends with its palm where the grasp needs it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import ApproachController, CollisionWorld, ControlOptions, RobotModel
from eyehand.control.tasks import PointOnPlane
from eyehand.data_synth import LBR_ARM, TOOL_SITE
from eyehand.errors import InputError
from eyehand.grasping import plan_grasps
from eyehand.grasping.control_tasks import control_tasks
from eyehand.grasping.nominal_hand import nominal_hand
from eyehand.grasping.palm_placement import EDGE_GAP, MAX_SPHERE_TILT, TABLE_GAP, max_closing_reach
from eyehand.perception import SceneObject, Superquadric, SuperquadricFit, SupportPlane

TABLE = SupportPlane(np.array([0.0, 0.0, 1.0]), 0.0)
BACK = 0.08
HAND = nominal_hand()
PERIOD = 0.02
# The bare arm of these tests has no hand to keep off things: the tasks alone are tested.
OPTIONS = ControlOptions(dt=PERIOD, eta=1.0, retreats=0)


def thing(kind, axes, e, turn=(0.0, 0.0, 0.0), at=(0.55, 0.05)) -> SceneObject:
    rotation = Rotation.from_rotvec(turn)
    high = np.abs(rotation.as_matrix()[2]) @ axes if kind in ("box", "cylinder") else axes[2]
    pose = RigidTransform.from_components([*at, high], rotation)
    solid = Superquadric(np.array(axes), e, pose, kind)
    return SceneObject(
        1, np.zeros((0, 3)), 900, SuperquadricFit(solid, True, "", np.zeros(9), (), 0.0), 1.0, 0
    )


BALL = thing("sphere", [0.0375] * 3, (1.0, 1.0))
SMALL_BALL = thing("sphere", [0.012] * 3, (1.0, 1.0))
CAN = thing("cylinder", [0.03, 0.03, 0.08], (0.1, 1.0))
JAR = thing("cylinder", [0.0375, 0.0375, 0.04], (0.1, 1.0))
STICK = thing("cylinder", [0.02, 0.02, 0.07], (0.1, 1.0), turn=(0.0, np.pi / 2, 0.0))
CARTON = thing("box", [0.045, 0.03, 0.10], (0.1, 0.1), turn=(0.0, 0.0, 0.4))
BRICK = thing("box", [0.05, 0.022, 0.015], (0.1, 0.1), turn=(0.0, 0.0, -0.7))
EGG = thing("ellipsoid", [0.045, 0.03, 0.03], (1.0, 1.0), turn=(0.0, 0.0, 1.0))


@pytest.fixture(scope="module")
def world() -> CollisionWorld:
    return CollisionWorld(RobotModel.load(LBR_ARM, TOOL_SITE))


def follow(world, item, name, q=None):
    """Best grasp of a name that the arm can do, and the tool's state before it and at it."""
    for plan in plan_grasps(item, TABLE):
        states = _states(world, plan, q) if plan.name == name else ()
        if len(states) == 2:
            return plan, *states
    raise AssertionError(f"no {name} was reached")


def _states(world, plan, q):
    q = world.robot.home if q is None else q
    states = []
    for back in (BACK, 0.0):
        controller = ApproachController(world, control_tasks(plan, HAND, back), OPTIONS)
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


def some(item, name):
    return next(plan for plan in plan_grasps(item, TABLE) if plan.name == name)


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
def test_the_palm_arrives_and_stood_back_before(world, item, name):
    plan, before, there = follow(world, item, name)
    grip = plan.geometry
    assert grip is not None
    centre, x, palm = grip.centre, there.rotation[:, 0], there.rotation[:, 2]
    to_centre = centre - there.position
    # The object lies on the palm's axis, but for the interval along its length or height.
    along = grip.up if plan.approach == "side" else there.rotation[:, 1]
    off = to_centre - (to_centre @ palm) * palm
    assert np.linalg.norm(off - (off @ along) * along) < 2e-3
    assert abs(off @ along) < 0.016 + 2e-3
    assert to_centre @ palm == pytest.approx(plan.standoff, abs=2e-3)
    assert (centre - before.position) @ before.rotation[:, 2] == pytest.approx(
        plan.standoff + BACK, abs=2e-3
    )
    if plan.approach == "top":
        assert palm @ grip.up < -np.cos(MAX_SPHERE_TILT + 0.01)
        tips = there.position[2] + max_closing_reach(HAND, grip.width, plan.opening) * palm[2]
        lean = 0.5 * HAND.spread(plan.opening) * np.linalg.norm(palm[:2])
        assert tips - lean > TABLE_GAP - 3e-3
    else:
        assert abs(palm @ grip.up) < 3e-3
        assert abs(there.rotation[2, 1]) > 1 - 1e-4
        assert there.position[2] - 0.5 * HAND.row > EDGE_GAP - 2e-3
    if grip.freedom == "none":
        assert x @ plan.closing > 1 - 1e-4


@pytest.mark.parametrize(
    ("item", "name", "free"),
    [(BALL, "top power", "turn"), (JAR, "top power", "turn"), (CAN, "side power", "side")],
)
def test_what_symmetry_leaves_free_ends_where_the_start_leads(world, item, name, free):
    ends = []
    for turn in (-0.5, 0.5):
        q = world.robot.home.copy()
        q[0] += turn
        q[6] += 2.0 * turn
        *_, there = follow(world, item, name, q)
        ends.append(there.rotation[:, 2 if free == "side" else 0])
    assert ends[0] @ ends[1] < np.cos(0.2)


def test_the_rows_stay_the_same_all_the_way():
    for item in (BALL, CAN, CARTON, BRICK):
        for plan in plan_grasps(item, TABLE):
            kinds = [
                [
                    (type(task), type(getattr(task, "task", None)))
                    for task in control_tasks(plan, HAND, back)
                ]
                for back in (0.0, 0.2)
            ]
            assert kinds[0] == kinds[1]
            assert len(kinds[0]) == len(plan.tasks)


def test_tasks_follow_tasks_that_touch_has_moved():
    plan = some(CARTON, "side power")
    off = np.array([0.004, -0.003, 0.0])
    moved = replace(plan, tasks=tuple(replace(t, point=t.point + off) for t in plan.tasks))
    for task, there in zip(control_tasks(plan, HAND), control_tasks(moved, HAND), strict=True):
        if isinstance(task, PointOnPlane):
            assert isinstance(there, PointOnPlane)
            assert there.offset - task.offset == pytest.approx(task.normal @ off)


def test_a_refusal_has_no_approach():
    (plan,) = plan_grasps(thing("box", [0.2, 0.2, 0.1], (0.1, 0.1)), TABLE)
    with pytest.raises(InputError, match="refused"):
        control_tasks(plan, HAND)
    with pytest.raises(InputError, match="retreat"):
        control_tasks(some(BALL, "top power"), HAND, -0.1)
