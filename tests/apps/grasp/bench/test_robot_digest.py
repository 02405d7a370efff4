"""The digest of a robot depends on all its files."""

import pytest

from eyehand.apps.grasp.bench.conditions import robot_digest

ROBOT = """<mujoco><compiler meshdir="meshes"/><include file="parts/hand.xml"/>
<asset><mesh name="arm" file="arm.stl"/></asset></mujoco>"""
HAND = """<mujocoinclude><asset><mesh name="tip" file="tip.obj"/></asset></mujocoinclude>"""


@pytest.fixture
def robot(tmp_path):
    """Return a robot of five files, beside a file that does not belong to it."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "meshes").mkdir()
    (tmp_path / "robot.xml").write_text(ROBOT)
    (tmp_path / "robot.hand.json").write_text("{}")
    (tmp_path / "parts" / "hand.xml").write_text(HAND)
    (tmp_path / "meshes" / "arm.stl").write_text("arm")
    (tmp_path / "meshes" / "tip.obj").write_text("tip")
    (tmp_path / "notes.txt").write_text("other")
    return tmp_path / "robot.xml"


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("robot.xml", True),
        ("robot.hand.json", True),
        ("parts/hand.xml", True),
        ("meshes/arm.stl", True),
        ("meshes/tip.obj", True),
        ("notes.txt", False),
    ],
)
def test_digest_depends_on_robot_files_only(robot, name, counts):
    before = robot_digest(robot)
    assert robot_digest(robot) == before
    file = robot.parent / name
    file.write_text(file.read_text() + " ")
    assert (robot_digest(robot) != before) == counts


def test_digest_depends_on_hand_description(robot):
    before = robot_digest(robot)
    (robot.parent / "robot.hand.json").unlink()
    assert robot_digest(robot) != before


def test_cyclic_and_invalid_xml_files_have_digest(tmp_path):
    for name, other in (("a", "b"), ("b", "a")):
        (tmp_path / f"{name}.xml").write_text(f'<mujoco><include file="{other}.xml"/></mujoco>')
    assert len(robot_digest(tmp_path / "a.xml")) == 12
    (tmp_path / "broken.xml").write_text("<mujoco")
    assert len(robot_digest(tmp_path / "broken.xml")) == 12
