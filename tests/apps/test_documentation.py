"""Every command and Python example in the README and the guides runs as shown."""

import re
import runpy
import shlex
import shutil
import textwrap
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.main import main
from eyehand.apps.mesh_file import mesh_bytes
from eyehand.apps.touch.view_sources import open_source
from eyehand.data_synth import LBR_ARM
from eyehand.data_synth.cell import GraspRobot
from eyehand.grasping import HandModel
from eyehand.perception import Superquadric, read_frame, write_cloud
from eyehand.perception.cameras import write_ros_frames
from eyehand.perception.io import write_png
from eyehand.perception.superquadric import mesh
from eyehand.tactile.sensors import record

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text()
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def code_blocks(language: str) -> list[str]:
    """Return the different code blocks of a language on all pages, in their order."""
    pattern = rf"```{language}\n(.*?)```"
    blocks = [one for page in PAGES for one in re.findall(pattern, page.read_text(), re.DOTALL)]
    return list(dict.fromkeys(blocks))


COMMANDS = list(
    dict.fromkeys(
        line.split("#")[0].strip() for block in code_blocks("sh") for line in block.splitlines()
    )
)

PRINTED = {
    "from eyehand.tactile import PhaseOptions": "phase: move",
    "from eyehand.tactile import MemoryFilter": "error of the predicted images 0.0",
    "from eyehand.grasping import select_prototype": "1 box [0.0",
    "from eyehand.grasping import load_hand": "% safe",
    "import json\n\nfrom eyehand.grasping": "% True\n",
    "import json\nfrom pathlib": "name='my gripper', stroke=0.06",
    "from eyehand.grasping import JawOptions, correct_depth": "hand [[",
    "from eyehand.control import App": "reached",
    "from eyehand.control import RobotModel": "shoulder elbow at most [0.5 2. ] rad/s",
    "from eyehand.perception import perceive\nfrom eyehand.perception.cameras": "6 objects",
    "import logging": "ended: clear",
    "import numpy as np\nfrom eyehand.apps": "placed",
    "import numpy as np\nfrom eyehand.tactile": "0 dead tactels",
    "import numpy as np\nfrom scipy": "1 object",
    "from eyehand.data_synth.pad": "no fault, phase task",
    "from eyehand.data_synth import TabletopOptions": "(480, 640) 3 objects",
    "from eyehand.perception import SegmentationOptions": "6 objects",
}
"""What an example prints, by its first line's beginning."""

URDF_JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<axis xyz="{axis}"/><limit lower="{low}" upper="3" velocity="{speed}" effort="9"/></joint>"""
"""Joint of an arm or a gripper. Their links have no inertia and no shape."""


def urdf(*joints: tuple) -> str:
    """Return a URDF of joints (name, kind, parent, child, axis, low, speed)."""
    names = ("name", "kind", "parent", "child", "axis", "low", "speed")
    links = dict.fromkeys(link for joint in joints for link in joint[2:4])
    text = "".join(f'<link name="{link}"/>' for link in links)
    text += "".join(URDF_JOINT.format(**dict(zip(names, one, strict=True))) for one in joints)
    return f'<robot name="{joints[0][0]}">{text}</robot>'


ARM_URDF = urdf(
    ("shoulder", "revolute", "foot", "upper", "0 0 1", -3, 0.5),
    ("elbow", "revolute", "upper", "flange", "0 1 0", -2, 2.0),
)
GRIPPER_URDF = urdf(
    ("left", "prismatic", "base", "left_jaw", "1 0 0", 0, 0.1),
    ("right", "prismatic", "base", "right_jaw", "-1 0 0", 0, 0.1),
)

MEASURING = ("eyehand evaluate", "eyehand chart", "eyehand stress")
"""Commands that measure a whole stage; each stage's own tests run shorter forms of them."""


@pytest.fixture(scope="module")
def named_files(tmp_path_factory) -> Path:
    """Return a folder with the files that the pages name, to be copied."""
    folder = tmp_path_factory.mktemp("named")
    (folder / "apps" / "sample").mkdir(parents=True)
    for file in (ROOT / "apps" / "sample").iterdir():
        shutil.copy(file, folder / "apps" / "sample")
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(500, 3))
    ball *= 0.04 / np.linalg.norm(ball, axis=1, keepdims=True)
    write_cloud(folder / "ball.ply", ball + np.array([0.0, 0.0, 0.04]))
    write_cloud(folder / "mug.pcd", ball * [1.0, 1.0, 1.4])
    (folder / "out" / "scene").mkdir(parents=True)
    frame = read_frame(folder / "apps" / "sample" / "depth.png")
    write_ros_frames(folder / "out" / "look.mcap", [frame])
    sensor, calibration = open_source("good", 0)
    record(sensor, folder / "out" / "touch.mcap", 3.0, calibration)
    write_ros_frames(folder / "bag.mcap", [frame])
    for file in (folder / "apps" / "sample").iterdir():
        shutil.copy(file, folder / "out" / "scene")
    write_png(folder / "robot.png", np.eye(*frame.depth.shape, dtype=np.uint16))
    shutil.copy(LBR_ARM, folder / "robot.xml")
    (folder / "arm.urdf").write_text(ARM_URDF)
    (folder / "gripper.urdf").write_text(GRIPPER_URDF)
    (folder / "meshes").mkdir()
    ball_solid = Superquadric(np.full(3, 0.04), (1.0, 1.0), RigidTransform.identity(), "sphere")
    (folder / "meshes" / "ball.stl").write_bytes(mesh_bytes(*mesh(ball_solid, 24), "stl"))
    return folder


@pytest.fixture
def folder(named_files, tmp_path, monkeypatch) -> Path:
    """Enter and return a new folder with the files that the pages name."""
    shutil.copytree(named_files, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_pages_contain_commands():
    assert sum(command.startswith("eyehand ") for command in COMMANDS) >= 8
    assert {"make demo", "make test"} <= set(COMMANDS)


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(command, marks=pytest.mark.slow if command.startswith(MEASURING) else ())
        for command in COMMANDS
    ],
)
def test_command_runs(command, folder, capsys, monkeypatch):
    words = shlex.split(command)
    if "--install-completion" in words:
        # It writes to the user's start-up file.
        monkeypatch.setenv("HOME", str(folder))
    if words[0] == "make":
        assert re.search(rf"^{words[1]}:", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
        return
    assert words[0] == "eyehand"
    with pytest.raises(SystemExit) as exit_info:
        main(words[1:])
    # No camera is connected where tests run, so that this command must fail.
    expected = 1 if "--oak" in words else 0
    assert exit_info.value.code == expected, capsys.readouterr().err


@pytest.mark.parametrize("example", code_blocks("python"), ids=lambda one: one.split("\n")[0])
def test_python_example_runs(example, folder, capsys):
    (printed,) = [prints for begins, prints in PRINTED.items() if example.startswith(begins)]
    (folder / "example.py").write_text(example)
    runpy.run_path(str(folder / "example.py"))
    assert printed in capsys.readouterr().out


def test_readme_is_short_enough_for_a_newcomer():
    assert len(README.splitlines()) <= 130


@pytest.mark.parametrize("page", PAGES, ids=lambda one: one.name)
def test_links_to_files_and_sections_resolve(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if target.startswith("https://"):
            continue
        name, _, section = target.partition("#")
        file = page if not name else (page.parent / name).resolve()
        assert file.exists(), target
        if section:
            titles = re.findall(r"^#+ (.*)$", file.read_text(), re.MULTILINE)
            anchors = {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
            assert section in anchors, target


def test_paths_and_functions_named_in_contributing_exist():
    packages = "perception|control|tactile|grasping|data_synth|apps|tests"
    for path in re.findall(rf"`((?:{packages})/[\w./]*)`", CONTRIBUTING):
        assert (ROOT / path).exists(), path
    pairs = re.findall(r"`([\w/]+\.py)`: `(\w+)`", CONTRIBUTING)
    assert len(pairs) >= 10
    for path, name in pairs:
        assert re.search(rf"^(class|def) {name}\b", (ROOT / path).read_text(), re.MULTILINE), name


def test_example_that_joins_arm_and_hand_makes_a_robot(folder):
    (example,) = re.findall(r"```python\n(.*?)```", CONTRIBUTING, flags=re.DOTALL)
    (folder / "join.py").write_text(textwrap.dedent(example))
    runpy.run_path(str(folder / "join.py"))

    robot = GraspRobot.of_file(folder / "robot.xml", "hand_palm")

    assert len(robot.joints) == 7
    np.testing.assert_allclose(robot.home[:4], [0.0, 0.6, 0.0, -1.8])
    hand = robot.measured_hand()
    assert isinstance(hand, HandModel)
    assert hand.fingers == ("left", "right", "thumb")
