"""Descriptions of parallel grippers: files, bounds, and the robots' own files."""

from __future__ import annotations

import json
from dataclasses import MISSING, fields, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.grasping.hands import ParallelHand, built_in_hands, generic_jaw, load_hand, write_hand
from eyehand.grasping.hands.hand_files import FOLDER, read_hand
from eyehand.grasping.hands.parallel_hand import SENSES, ToolPose

ROBOTS = Path(__file__).resolve().parents[4] / "shared" / "robots"


def test_hand_survives_its_file(tmp_path):
    for name in built_in_hands():
        hand = load_hand(name)
        write_hand(hand, tmp_path / "hand.json")
        assert read_hand(tmp_path / "hand.json") == hand


def test_unknown_name_lists_the_valid_ones():
    with pytest.raises(InputError, match=r"2f85.*panda"):
        load_hand("pandda")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": "x"}, "schema"),
        ({"kind": "claw"}, "kind.* must be .parallel. or .fingers., got .claw."),
        ({"stroke": -0.1}, "stroke must be 0 to 1 m, got -0.1"),
        ({"stroke": 80.0}, r"got 80.0: are the lengths in m\?"),
        ({"stroke": "wide"}, "'stroke' must be a number, got 'wide'"),
        ({"colour": 1}, "unknown keys colour"),
        ({"finger_boxes": []}, "at least one box"),
        ({"finger_boxes": [{"low": [0, 0, 0]}]}, "'low' and 'high'"),
        ({"palm_boxes": []}, "palm_boxes must hold at least one box, got none"),
        ({"force": [70, 10]}, "force must be a range"),
        ({"force": [0, 3500]}, r"force must be at most 1000 N on each jaw, got 3500: is it in N\?"),
        ({"senses": ["smell"]}, "unknown senses smell"),
        ({"min_opening": 0.2}, "min_opening"),
        ({"mount_distance": 140}, "mount_distance must be >= 0 and below 1 m, got 140"),
        ({"mount_distance": -0.1}, "mount_distance must be >= 0 and below 1 m, got -0.1"),
        ({"pad_height": 0.09}, "pad_height must be at most 0.05"),
        ({"palm_boxes": [{"low": [0, 0, 0.05], "high": [1, 1, 0.1]}]}, "end at 0.1000 m"),
        (
            {"finger_boxes": [{"low": [-0.02, -0.02, -0.1], "high": [0, 0.02, 0]}]},
            "they begin at -0.0200 m",
        ),
        (
            {"finger_boxes": [{"low": [-0.01, -0.01, -0.05], "high": [0.02, 0.01, 0]}]},
            "must begin at its face, x = 0, .* they begin at -0.0100 m",
        ),
        (
            {"finger_boxes": [{"low": [0.04, -0.01, -0.05], "high": [0.06, 0.01, 0]}]},
            "also of the open hand; they begin at 0.0400 m",
        ),
        (
            {"palm_boxes": [{"low": [-0.1, -0.03, -0.14], "high": [0.1, 0.03, -0.02]}]},
            "end at z = -finger_depth = -0.0463 m, palm_boxes end at -0.0200 m",
        ),
    ],
)
def test_invalid_file_is_refused_in_one_line(tmp_path, change, message):
    path = tmp_path / "hand.json"
    write_hand(load_hand("panda"), path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=message) as error:
        read_hand(path)
    assert "\n" not in str(error.value)


def test_missing_key_is_named(tmp_path):
    path = tmp_path / "hand.json"
    write_hand(load_hand("panda"), path)
    data = json.loads(path.read_text())
    del data["stroke"]
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match="missing keys: stroke"):
        read_hand(path)


def test_jaws_are_mirror_images_an_opening_apart():
    hand = generic_jaw(stroke=0.1, finger_depth=0.05, finger_width=0.02)
    right, left = hand.jaw_boxes(0.06)
    assert right[0, 0] == pytest.approx(0.03)
    assert left[1, 0] == pytest.approx(-0.03)
    np.testing.assert_allclose(right[:, 1:], left[:, 1:])


@pytest.mark.parametrize(
    ("name", "file", "opened", "closed", "axis", "fingers"),
    [
        ("panda", "franka_emika_panda/hand.xml", 255, 0, 1, ("left_finger", "right_finger")),
        (
            "2f85",
            "robotiq_2f85/2f85.xml",
            0,
            255,
            0,
            ("left_pad", "right_pad", "left_f", "right_f"),
        ),
    ],
)
def test_built_in_hand_encloses_the_fingers_of_its_file(name, file, opened, closed, axis, fingers):
    """The boxes hold all collision geometry of the fingers, and the stroke is that of the pads."""
    path = ROBOTS / file
    if not path.is_file():
        pytest.skip(f"no {path}")
    hand = load_hand(name)
    assert hand.checked
    for control, opening in ((opened, hand.stroke), (closed, 0.0)):
        points = _finger_points(path, control, fingers)
        points = points[:, [axis, 1 - axis, 2]] - [0.0, 0.0, hand.mount_distance]
        gap = 2 * np.abs(points[points[:, 2] > -0.03, 0]).min()
        assert gap == pytest.approx(opening, abs=2e-3)
        low, high = np.moveaxis(np.concatenate([hand.jaw_boxes(gap), hand.fixed_boxes()]), 1, 0)
        inside = (points[:, None] > low - 1e-3) & (points[:, None] < high + 1e-3)
        assert inside.all(axis=2).any(axis=1).all()
        assert points[:, 2].max() <= 1e-3
    assert points[:, 2].max() == pytest.approx(0.0, abs=1e-3)


def _finger_points(path: Path, control: float, names: tuple[str, ...]) -> np.ndarray:
    """Return the corners of the fingers' collision geometry in the hand's frame, (N, 3), m."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    model.opt.gravity[:] = 0.0
    data.ctrl[:] = control
    mujoco.mj_step(model, data, 2000)
    clouds = []
    for geom in range(model.ngeom):
        body = model.body(model.geom_bodyid[geom]).name
        if not model.geom_contype[geom] or not body.startswith(names):
            continue
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[geom]
            first = model.mesh_vertadr[mesh]
            local = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        else:
            grid = np.meshgrid([-1, 1], [-1, 1], [-1, 1])
            local = np.reshape(grid, (3, -1)).T * model.geom_size[geom]
        clouds.append(local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    return np.vstack(clouds)


def test_joints_follow_the_opening():
    for name in built_in_hands():
        hand = load_hand(name)
        assert hand.joints
        for joint, at_open, at_closed in zip(
            hand.joints, hand.joint_positions(hand.stroke), hand.joint_positions(0.0), strict=True
        ):
            assert (at_open, at_closed) == (joint.open, joint.closed)
    assert load_hand("panda").joint_positions(0.05).sum() == pytest.approx(0.05)


@pytest.mark.parametrize("joints", [3, [{"name": "a"}], [{"name": "a", "open": "x", "closed": 0}]])
def test_invalid_joints_are_refused(tmp_path, joints):
    path = tmp_path / "hand.json"
    write_hand(load_hand("panda"), path)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"joints": joints}))
    with pytest.raises(InputError, match=r"joint|'open'"):
        read_hand(path)


def test_schema_has_the_fields_of_a_hand():
    schema = json.loads((FOLDER / "schema.json").read_text())
    names = {field.name for field in fields(ParallelHand)}
    assert set(schema["properties"]) == names | {"schema"}
    needed = {field.name for field in fields(ParallelHand) if field.default is MISSING}
    assert set(schema["required"]) == needed | {"schema", "kind"}
    assert schema["properties"]["senses"]["items"]["enum"] == list(SENSES)
    page = (Path(__file__).parents[3] / "docs/guides/hand_description.md").read_text()
    for name in (*names, *built_in_hands()):
        assert f"`{name}`" in page


@pytest.mark.parametrize("change", [{"pad_width": 0.05}, {"finger_depth": 0.5}])
def test_pad_and_depth_must_fit_the_fingers(change):
    with pytest.raises(InputError, match=f"{next(iter(change))} must be at most"):
        replace(load_hand("panda"), **change)


def test_link_pose_puts_the_open_pads_around_the_object_if_one_jaw_moves():
    half = np.sqrt(0.5)
    tool = ToolPose("base", (0.0, 0.0, 0.1), (half, 0.0, 0.0, half))
    hand = replace(generic_jaw(stroke=0.08), middle_shift=(0.04, 0.0), tool=tool)
    T_scene_tcp = RigidTransform.from_translation([0.3, 0.1, 0.2])

    link = hand.link_pose(T_scene_tcp, 0.06)

    # The middle of the pads, 60 mm apart, in the link: the standing jaw touches the tool frame.
    middle = RigidTransform.from_components(
        tool.position, Rotation.from_euler("z", 90, degrees=True)
    )
    np.testing.assert_allclose((link * middle).apply([0.03, 0, 0]), [0.3, 0.1, 0.2], atol=1e-12)
    np.testing.assert_allclose(hand.closed_pose(T_scene_tcp, 0.0).translation, [0.3, 0.1, 0.2])


@pytest.mark.parametrize("width", [80.0, -0.01, np.nan])
def test_link_pose_refuses_a_width_that_the_hand_does_not_have(width):
    with pytest.raises(InputError, match=r"width must be from 0 to the stroke 0\.08 m, got"):
        load_hand("panda").link_pose(RigidTransform.identity(), width)


def test_link_pose_needs_the_tool_frame():
    with pytest.raises(InputError, match="hande has no `tool`: add the body"):
        load_hand("hande").link_pose(RigidTransform.identity(), 0.05)
