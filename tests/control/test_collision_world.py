"""The collision world: pairs, obstacles that change, held objects, and invalid calls."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import collision_world, world_spec
from eyehand.control.collision_world import CollisionWorld
from eyehand.control.options import CollisionOptions
from eyehand.control.robot_model import RobotModel
from eyehand.control.shapes import Box, Capsule, ConvexMesh, Cylinder, Obstacle, Shape, Sphere
from eyehand.control.world_spec import build_world
from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

ARM = """
<mujoco><compiler angle="radian"/>
<worldbody>
  <geom name="table" type="box" size=".5 .5 .01" pos="0 0 -.01"/>
  <body name="foot"><geom name="foot" type="cylinder" size=".06 .05" pos="0 0 .05"/>
  <body name="link1" pos="0 0 .1"><joint name="j1" axis="0 0 1" range="-3 3"/>
  <geom name="shell1" type="capsule" size=".05" fromto="0 0 0 0 0 .2"/>
  <body name="link2" pos="0 0 .2"><joint name="j2" axis="0 1 0" range="-2.5 2.5"/>
  <geom name="shell2" type="capsule" size=".04" fromto="0 0 0 0 0 .3"/>
  <geom name="trim" type="box" size=".2 .2 .2" contype="0" conaffinity="0"/>
  <body name="link3" pos="0 0 .3"><joint name="j3" axis="0 1 0" range="-2.8 2.8"/>
  <geom type="capsule" size=".04" fromto="0 0 0 0 0 .2"/>
  <body name="hand" pos="0 0 .22"><geom type="box" size=".05 .05 .02"/>
  <geom type="sphere" size=".01" pos="0 0 .03"/><site name="tool" pos="0 0 .06" euler="0 .5 0"/>
  <body name="finger" pos=".03 0 .03"><joint name="grip" type="slide" axis="1 0 0"
  range="-.02 .02"/>  <geom name="finger" type="box" size=".005 .01 .03" pos="0 0 .03"/></body>
  </body></body></body></body></body>
</worldbody>{more}</mujoco>
"""
translation = RigidTransform.from_translation


def _robot(more: str = "", **options: Any) -> RobotModel:
    joints = options.pop("joints", ["j1", "j2", "j3"])
    return RobotModel.load(ARM.format(more=more), "tool", joints=joints, **options)


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return _robot()


def _distance(world: CollisionWorld, q: np.ndarray, part: str, other: str) -> float:
    near = world.proximity(q)
    return float(near.distance[near.names.index((part, other))])


def test_pairs_include_all_parts_with_relative_motion(robot: RobotModel) -> None:
    pairs = CollisionWorld(robot).pair_names
    assert set(pairs) == {
        *(
            (part, "table")
            for part in ("shell1", "shell2", "link3", "hand[0]", "hand[1]", "finger")
        ),
        *((part, "foot") for part in ("shell2", "link3", "hand[0]", "hand[1]", "finger")),
        *(("shell1", part) for part in ("link3", "hand[0]", "hand[1]", "finger")),
        *(("shell2", part) for part in ("hand[0]", "hand[1]", "finger")),
    }


def test_excluded_pairs_and_pairs_close_at_home_are_ignored() -> None:
    more = '<contact><exclude body1="link1" body2="link3"/></contact>'
    world = CollisionWorld(_robot(more), options=CollisionOptions(self_margin=0.17))
    assert ("shell1", "link3") not in world.pair_names
    assert ("shell2", "hand[0]") in world.ignored
    assert ("shell2", "hand[0]") not in world.pair_names
    assert ("shell1", "hand[0]") in world.pair_names


def test_near_parts_are_ignored_only_if_no_joint_moves_them_apart() -> None:
    # The disc turns 8 mm above the plate. At home the lug is 8 mm beside the post.
    wrist = """<mujoco><compiler angle="radian"/><worldbody>
    <body name="one"><joint name="j1" axis="0 1 0" range="-2 2"/>
    <geom name="plate" type="box" size=".1 .1 .01" pos="0 0 -.01"/>
    <geom name="post" type="box" size=".01 .01 .05" pos=".038 0 .06"/>
    <body name="two"><joint name="j2" axis="0 0 1" range="-3 3"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><body name="three">
    <joint name="j3" axis="0 0 1" range="-3 3"/>
    <geom name="disc" type="cylinder" size=".01 .01" pos="0 0 .018"/>
    <geom name="lug" type="box" size=".01 .01 .01" pos=".01 0 .06"/><site name="tool"/>
    </body></body></body></worldbody></mujoco>"""
    world = CollisionWorld(RobotModel.load(wrist, "tool", home=[0.0, 0.0, 0.0]))
    assert world.ignored == (("plate", "disc"),)
    # 8 mm count as 11 mm, so that the arm can come home. Contact stays at zero.
    assert _distance(world, np.zeros(3), "post", "lug") == pytest.approx(0.011, abs=1e-5)


def test_parts_that_overlap_environment_at_home_are_ignored() -> None:
    world = CollisionWorld(_robot(home=[0.0, 2.4, 0.3]))
    assert ("link3", "table") in world.ignored
    assert ("shell2", "table") in world.pair_names


def test_controlled_finger_is_not_paired_with_its_parent() -> None:
    pairs = CollisionWorld(_robot(joints=["j1", "j2", "j3", "grip"])).pair_names
    assert ("link3", "finger") in pairs or ("finger", "link3") in pairs
    assert ("hand[0]", "finger") not in pairs


def test_robot_without_collision_geoms_uses_visual_geoms() -> None:
    text = ARM.format(more="").replace("<geom ", '<geom contype="0" conaffinity="0" ')
    text = text.replace('contype="0" conaffinity="0"/>', "/>")
    world = CollisionWorld(RobotModel.load(text, "tool"), [_ball("ball", 0.6, 0.0, 0.5)])
    assert ("trim", "ball") in world.pair_names


def _ball(name: str, x: float, y: float, z: float, radius: float = 0.1) -> Obstacle:
    return Obstacle(name, Sphere(radius), translation([x, y, z]))


def test_distance_to_sphere_is_exact(robot: RobotModel) -> None:
    world = CollisionWorld(robot, [_ball("ball", 0.25, 0.0, 0.2)])
    near = world.proximity(np.zeros(3))
    index = near.names.index(("shell1", "ball"))
    np.testing.assert_allclose(near.distance[index], 0.25 - 0.05 - 0.1, atol=1e-15)
    np.testing.assert_allclose(near.normal[index], [-1.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(near.on_robot[index], [0.05, 0.0, 0.2], atol=1e-15)
    np.testing.assert_allclose(near.on_other[index], [0.15, 0.0, 0.2], atol=1e-15)
    np.testing.assert_allclose(near.rows[index], 0.0, atol=1e-15)


def test_obstacles_can_be_added_moved_and_removed(robot: RobotModel) -> None:
    world = CollisionWorld(robot)
    q = np.zeros(3)
    world.add(_ball("ball", 0.25, 0.0, 0.2))
    world.add(Obstacle("box", Box(np.array([0.1, 0.02, 0.03])), translation([0.0, 0.3, 0.2])))
    world.move("ball", translation([0.2, 0.0, 0.2]))
    assert _distance(world, q, "shell1", "ball") == pytest.approx(0.05)
    turned = RigidTransform.from_components(
        [0.0, 0.2, 0.2], Rotation.from_rotvec([0, 0, np.pi / 2])
    )
    world.move("box", turned)
    assert _distance(world, q, "shell1", "box") == pytest.approx(0.05)
    assert [one.name for one in world.obstacles] == ["ball", "box"]
    np.testing.assert_allclose(world.obstacles[0].pose.translation, [0.2, 0.0, 0.2])
    world.remove("ball")
    assert all(other != "ball" for _, other in world.pair_names)
    # The free slot is reused for another shape.
    world.add(Obstacle("can", Cylinder(0.05, 0.1), translation([0.15, 0.0, 0.2])))
    assert _distance(world, q, "shell1", "can") == pytest.approx(0.05)


SHAPES: list[Shape] = [Sphere(0.05), Box(np.full(3, 0.05)), Capsule(0.05, 0.1), Cylinder(0.05, 0.1)]


def test_worlds_of_a_robot_share_one_compilation_but_no_obstacles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    compiled = []
    original = world_spec.compile_spec
    monkeypatch.setattr(
        world_spec, "compile_spec", lambda spec: compiled.append(spec) or original(spec)
    )
    robot = _robot()
    first = CollisionWorld(robot, [_ball("a", 0.25, 0.0, 0.45)])
    second = CollisionWorld(robot, [_ball("b", 0.25, 0.0, 0.45, radius=0.2)])
    assert len(compiled) == 1
    q = np.zeros(3)
    gaps = _distance(first, q, "shell2", "a"), _distance(second, q, "shell2", "b")
    assert gaps[0] - gaps[1] == pytest.approx(0.1, abs=1e-9)
    assert not {"a", "b"} <= {name for pair in first.pair_names for name in pair}


def test_meshes_for_display_are_not_compiled_into_worlds() -> None:
    mesh = '<asset><mesh name="cover" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/></asset>'
    cover = '<geom type="mesh" mesh="cover" contype="0" conaffinity="0"/>'
    text = ARM.format(more=mesh).replace('<geom name="trim"', f'{cover}<geom name="trim"')
    robot = RobotModel.load(text, "tool", joints=["j1", "j2", "j3"])
    world = build_world(robot, 1, ())
    assert robot.model.nmesh == 1
    assert world.model.nmesh == 0
    np.testing.assert_array_equal(
        world.model.geom_bodyid[: robot.model.ngeom], robot.model.geom_bodyid
    )
    plain, q = CollisionWorld(_robot()), np.array([0.3, 1.0, -2.0])
    np.testing.assert_array_equal(
        CollisionWorld(robot).proximity(q).distance, plain.proximity(q).distance
    )


def test_more_obstacles_than_slots_keep_existing_obstacles(
    robot: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    default_slots = CollisionWorld(robot, options=CollisionOptions(cut_off=2.0))
    monkeypatch.setattr(collision_world, "SLOTS", 1)
    one_slot = CollisionWorld(robot, options=CollisionOptions(cut_off=2.0))
    rng = np.random.default_rng(4)
    corners = rng.normal(size=(10, 3)) * 0.1
    velocity = np.arange(6.0)
    for number in range(9):
        shape = ConvexMesh(corners) if number == 4 else SHAPES[number % 4]
        pose = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
        for world in (one_slot, default_slots):
            world.add(Obstacle(f"o{number}", shape, pose))
            world.move(f"o{number}", pose, velocity)
    for world in (one_slot, default_slots):
        world.remove("o2")
        world.attach("held", ConvexMesh(corners), translation([0.0, 0.0, 0.1]))
    q = np.array([0.3, 0.5, -0.8])
    one, other = one_slot.proximity(q), default_slots.proximity(q)
    assert one.names == other.names
    for field in ("distance", "normal", "on_robot", "on_other", "rows", "drift"):
        np.testing.assert_allclose(getattr(one, field), getattr(other, field), atol=1e-9)


def test_mesh_of_box_has_same_distances_as_box(robot: RobotModel) -> None:
    half = np.array([0.05, 0.08, 0.03])
    corners = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T * half + [0.02, 0.0, 0.01]
    rng = np.random.default_rng(2)
    pose = RigidTransform.from_components([0.3, 0.1, 0.4], Rotation.random(rng=rng))
    options = CollisionOptions(cut_off=2.0)
    inner = pose * translation([0.02, 0.0, 0.01])
    boxed = CollisionWorld(robot, [Obstacle("o", Box(half), inner)], options=options)
    meshed = CollisionWorld(robot, [Obstacle("o", ConvexMesh(corners), pose)], options=options)
    for q in rng.uniform(-1, 1, (5, 3)):
        one, other = boxed.proximity(q), meshed.proximity(q)
        assert one.names == other.names
        # Meshes are stored in single precision. Both depths are minimum translation distances.
        np.testing.assert_allclose(one.distance, other.distance, atol=1e-7)


def test_box_stands_for_a_mesh_until_a_thread_has_compiled_it(robot: RobotModel) -> None:
    corners = np.random.default_rng(3).normal(size=(40, 3)) * 0.05
    pose = RigidTransform.from_components([0.3, 0.1, 0.4], Rotation.from_rotvec([0.3, 0.2, 0.5]))
    options = CollisionOptions(cut_off=2.0)
    expected = CollisionWorld(robot, [Obstacle("o", ConvexMesh(corners), pose)], options=options)
    low, high = corners.min(axis=0), corners.max(axis=0)
    box = Obstacle("o", Box(0.5 * (high - low)), pose * translation(0.5 * (low + high)))
    boxed = CollisionWorld(robot, [box], options=options)
    world = CollisionWorld(robot, options=options)
    world.add(Obstacle("o", ConvexMesh(corners), translation([2.0, 0.0, 0.0])), background=True)
    # A second one is added, and one is moved, while the thread compiles.
    world.add(Obstacle("far", ConvexMesh(corners), translation([0.0, 3.0, 0.0])), background=True)
    world.move("o", pose, np.zeros(6))
    world.remove("far")
    q = np.array([0.3, 0.5, -0.8])
    np.testing.assert_allclose(world.proximity(q).distance, boxed.proximity(q).distance, atol=1e-12)
    deadline = time.monotonic() + 60.0
    while world.preparing and time.monotonic() < deadline:
        world.advance(0.005)
        time.sleep(0.001)
    found, exact = world.proximity(q), expected.proximity(q)
    assert found.names == exact.names
    np.testing.assert_allclose(found.distance, exact.distance, atol=1e-12)
    assert not np.allclose(found.distance, boxed.proximity(q).distance, atol=1e-4)


def test_drift_equals_finite_difference_of_obstacle_motion(robot: RobotModel) -> None:
    rng = np.random.default_rng(5)
    pose = RigidTransform.from_components([0.25, 0.1, 0.5], Rotation.random(rng=rng))
    world = CollisionWorld(robot, [Obstacle("box", Box(np.array([0.1, 0.05, 0.08])), pose)])
    q = np.array([0.2, 0.4, 0.3])
    twist = rng.normal(size=6)
    world.move("box", pose, twist)
    near = world.proximity(q)
    with_box = [k for k, names in enumerate(near.names) if names[1] == "box"]
    assert len(with_box) >= 2
    step = 1e-6
    found = []
    for sign in (1.0, -1.0):
        turn = Rotation.from_rotvec(sign * step * twist[3:]) * pose.rotation
        moved = RigidTransform.from_components(pose.translation + sign * step * twist[:3], turn)
        world.move("box", moved)
        found.append(world.proximity(q))
    slope = (found[0].distance - found[1].distance) / (2 * step)
    np.testing.assert_allclose(near.drift, slope, atol=1e-6)
    assert np.all(near.drift[[k for k in range(len(near.names)) if k not in with_box]] == 0.0)
    assert np.all(found[1].drift == 0.0)


def test_returned_proximity_is_not_overwritten(robot: RobotModel) -> None:
    world = CollisionWorld(robot, [_ball("ball", 0.25, 0.0, 0.2)])
    first = world.proximity(np.zeros(3))
    copies = {name: np.copy(value) for name, value in vars(first).items()}
    world.proximity(np.ones(3))
    world.move("ball", translation([0.2, 0.0, 0.2]))
    world.proximity(np.zeros(3))
    for name, value in copies.items():
        np.testing.assert_array_equal(getattr(first, name), value)


def test_only_pairs_within_cut_off_are_reported(robot: RobotModel) -> None:
    sphere = _ball("ball", 0.25, 0.0, 0.2)
    assert ("shell1", "ball") in CollisionWorld(robot, [sphere]).proximity(np.zeros(3)).names
    strict = CollisionWorld(robot, [sphere], options=CollisionOptions(cut_off=0.0999))
    assert ("shell1", "ball") not in strict.proximity(np.zeros(3)).names
    far = CollisionWorld(robot, options=CollisionOptions(cut_off=1e-3)).proximity(np.zeros(3))
    assert far.names == ()
    assert far.rows.shape == (0, 3)
    assert far.normal.shape == (0, 3)


def test_cut_off_keeps_all_close_pairs(robot: RobotModel) -> None:
    rng = np.random.default_rng(8)
    obstacles = [
        Obstacle(
            f"o{k}", SHAPES[k % 4], translation(rng.uniform([-0.5, -0.5, 0.1], [0.5, 0.5, 0.8]))
        )
        for k in range(8)
    ]
    near = CollisionWorld(robot, obstacles, options=CollisionOptions(cut_off=0.1))
    unlimited = CollisionWorld(robot, obstacles, options=CollisionOptions(cut_off=9.0))
    for q in rng.uniform(-2, 2, (20, 3)):
        one, every = near.proximity(q), unlimited.proximity(q)
        assert set(every.names) == set(unlimited.pair_names)
        expected = [name for name, d in zip(every.names, every.distance, strict=True) if d < 0.1]
        assert list(one.names) == expected


def test_held_object_moves_with_frame(robot: RobotModel) -> None:
    world = CollisionWorld(robot, options=CollisionOptions(cut_off=5.0))
    pose = RigidTransform.from_components([0.02, 0.01, 0.05], Rotation.from_rotvec([0.1, 0.5, 0.2]))
    world.add(_ball("ball", 0.5, 0.3, 0.4))
    world.attach("stick", Capsule(0.01, 0.1), pose)
    for q in np.random.default_rng(1).uniform(-1, 1, (3, 3)):
        near = world.proximity(q)
        index = near.names.index(("stick", "ball"))
        state = robot.at(q)
        frame = RigidTransform.from_components(state.position, Rotation.from_matrix(state.rotation))
        ends = (frame * pose).apply([[0, 0, -0.1], [0, 0, 0.1]])
        along = ends[1] - ends[0]
        where = np.clip((np.array([0.5, 0.3, 0.4]) - ends[0]) @ along / (along @ along), 0, 1)
        expected = np.linalg.norm(ends[0] + where * along - [0.5, 0.3, 0.4]) - 0.11
        assert near.distance[index] == pytest.approx(expected, abs=1e-12)
        slopes = [
            (
                _distance(world, q + move, "stick", "ball")
                - _distance(world, q - move, "stick", "ball")
            )
            / 2e-6
            for move in 1e-6 * np.eye(3)
        ]
        np.testing.assert_allclose(near.rows[index], slopes, atol=1e-7)
    names = world.pair_names
    assert ("stick", "table") in names
    assert ("stick", "shell1") in names
    assert ("stick", "hand[0]") not in names
    assert ("stick", "finger") not in names
    world.detach("stick")
    assert all("stick" not in pair for pair in world.pair_names)


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (
            lambda w: w.move("bal", translation([0, 0, 0])),
            "unknown obstacle 'bal'; there are: ball",
        ),
        (lambda w: w.remove("table"), "unknown obstacle 'table'; there are: ball"),
        (lambda w: w.detach("ball"), "unknown held object 'ball'; there are: none"),
        (lambda w: w.add(_ball("ball", 0, 0, 0)), "'ball' is taken"),
        (lambda w: w.attach("ball", Sphere(0.1), translation([0, 0, 0])), "'ball' is taken"),
        (lambda w: w.add(_ball("shell1", 0, 0, 0)), "part of the robot's file"),
        (lambda w: w.move("ball", translation([float("nan"), 0, 0])), "pose must be finite"),
        (lambda w: w.move("ball", translation([0, 0, 0]), [0, 0, 1]), r"velocity.*shape \(6,\)"),
        (lambda w: w.move("ball", translation([0, 0, 0]), "fast"), "velocity.*must be numbers"),
        (
            lambda w: w.move("ball", translation([0, 0, 0]), np.full(6, np.inf)),
            "velocity.*must be finite",
        ),
        (lambda w: w.proximity([0.0, 0.0]), r"q must have shape \(3,\)"),
        (lambda w: w.proximity([0.0, 0.0, float("nan")]), "q must be finite"),
        (lambda w: CollisionOptions(cut_off=0.0), "cut_off must be finite and > 0"),
        (lambda w: CollisionOptions(self_margin=-1.0), "self_margin must be"),
    ],
)
def test_invalid_calls_raise_with_valid_values(
    robot: RobotModel, act: Callable[[CollisionWorld], object], message: str
) -> None:
    world = CollisionWorld(robot, [_ball("ball", 0.25, 0.0, 0.2)])
    before = world.pair_names
    with pytest.raises(InputError, match=message):
        act(world)
    assert world.pair_names == before


def test_height_fields_are_rejected() -> None:
    more = '<asset><hfield name="h" nrow="3" ncol="3" size="1 1 1 1"/></asset>'
    text = ARM.format(more=more).replace(
        '<body name="foot">', '<geom name="hills" type="hfield" hfield="h"/><body name="foot">'
    )
    with pytest.raises(InputError, match="hills is a height field"):
        CollisionWorld(RobotModel.load(text, "tool"))


@pytest.mark.parametrize(
    "default",
    [
        '<mesh scale="0.001 0.001 0.001"/>',
        '<mesh maxhullvert="4"/>',
        '<geom pos="0 0 0.5" quat="0.3 0.4 0.5 0.6"/>',
        '<geom contype="0" conaffinity="0"/>',
        '<geom shellinertia="true"/>',
    ],
)
def test_defaults_of_robot_file_do_not_change_obstacles(default: str) -> None:
    arm = f"""<mujoco><compiler discardvisual="true"/><default>{default}</default><worldbody>
    <body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint axis="0 0 1" name="turn"/>
    <geom type="capsule" size="0.05 0.2" pos="0 0 0" quat="1 0 0 0" contype="1" conaffinity="1"/>
    <site name="tip"/></body></worldbody></mujoco>"""
    corners = 0.1 * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    world = CollisionWorld(
        RobotModel.load(arm, "tip"),
        [
            Obstacle("mesh", ConvexMesh(corners), translation([0.2, 0.0, 0.0])),
            Obstacle("box", Box(np.full(3, 0.1)), translation([-0.2, 0.0, 0.0])),
        ],
    )
    near = world.proximity(world.robot.home)
    np.testing.assert_allclose(near.distance, 0.05, atol=1e-9)


@pytest.mark.parametrize("invalid", [Sphere(0.1), [Sphere(0.1)], "box"])
def test_world_rejects_objects_that_are_no_obstacles(robot: RobotModel, invalid: Any) -> None:
    with pytest.raises(InputError, match="Obstacle"):
        CollisionWorld(robot, invalid)
    with pytest.raises(InputError, match="Obstacle"):
        CollisionWorld(robot).add(invalid)


def test_world_rejects_single_obstacle_and_invalid_robot(robot: RobotModel) -> None:
    sphere: Any = Obstacle("ball", Sphere(0.1), RigidTransform.identity())
    with pytest.raises(InputError, match="list of Obstacle"):
        CollisionWorld(robot, sphere)
    with pytest.raises(InputError, match=r"RobotModel\.load"):
        CollisionWorld(sphere)
