"""Every script in `examples/` is short and does what it says."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
PRINTED = {
    "perceive_frame": "object 6: ",
    "fit_cloud": "cylinder: radius 33",
    "parallel_gripper": "%",
    "simulated_pick": "ended: clear",
    "arm_around_obstacles": "reached after ",
    "tactile_servo": "slide ",
}
"""Example → what it prints."""
ELSEWHERE = {"remote_robot", "evaluate_on_cluster"}
"""Examples with a test of their own: tests/grasping/test_remote_robot.py, and below."""


def test_every_example_is_tested_and_short():
    names = {path.stem for path in EXAMPLES.glob("*.py")}
    assert names == set(PRINTED) | ELSEWHERE
    for path in EXAMPLES.glob("*.py"):
        assert len(path.read_text().splitlines()) <= 40, path.name


@pytest.mark.parametrize("name", PRINTED)
def test_example_prints_its_result(name, capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("sys.argv", [name])
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    assert PRINTED[name] in capsys.readouterr().out


def test_recorded_contact_is_followed_towards_the_middle(capsys):
    runpy.run_path(str(EXAMPLES / "tactile_servo.py"))["main"]()
    lines = capsys.readouterr().out.splitlines()
    centres = [float(line.split()[1]) for line in lines]
    assert centres == sorted(centres, reverse=True)
    assert centres[-1] < 1.0


@pytest.mark.parametrize("address", ["", "tcp://host:8786"])
def test_evaluation_goes_to_the_cluster_only_if_one_is_named(address, monkeypatch):
    calls = []
    monkeypatch.setattr("eyehand.apps.main.main", calls.append)
    example = runpy.run_path(str(EXAMPLES / "evaluate_on_cluster.py"))
    example["main"](*[address] if address else [], scenes=2)
    (words,) = calls
    assert words[:2] == ["evaluate", "grasp"]
    assert ("--cluster" in words) == bool(address)
