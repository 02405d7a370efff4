"""The load on a lifted object, and the force that the hand squeezes it with."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from eyehand.apps.grasp.bench.held_load import GRAVITY, LOAD_DELAY_S, HeldLoad
from eyehand.apps.grasp.bench.stress_objects import can_on_table
from eyehand.data_synth.cell import GraspWorld, SimRobot
from eyehand.grasping import JawReading


def holding_robot(loads: list[float]) -> Any:
    """Return a robot that holds an object of 0.2 kg, and notes the loads on it."""
    return SimpleNamespace(
        mass=lambda name: 0.2,
        is_lifted=lambda name: True,
        exact_hand_reading=lambda: JawReading(0.05),
        set_load=lambda name, force: loads.append(force),
    )


def cycle(phase: str, time: float) -> Any:
    reading = SimpleNamespace(time=time)
    return SimpleNamespace(phase=phase, reading=reading, force=np.array([3.0, 3.0, 0.0]))


def test_load_acts_during_the_check_and_squeeze_is_the_force_over_the_least_one():
    loads: list[float] = []
    held = HeldLoad(holding_robot(loads), "can", 1.5, 0.6)
    held.update(cycle("lift", 0.0))
    assert (held.lifted, held.squeeze, loads) == (False, None, [])
    held.update(cycle("check", 1.0))
    assert held.lifted
    assert loads == [0.0]
    assert held.squeeze == pytest.approx(6.0 / (0.2 * GRAVITY / 0.6))
    held.update(cycle("check", 1.0 + LOAD_DELAY_S))
    assert loads[-1] == pytest.approx(0.5 * 0.2 * GRAVITY)
    assert held.squeeze == pytest.approx(12.0 / (2.5 * 0.2 * GRAVITY / 0.6))
    held.update(cycle("place", 3.0))
    assert loads[-1] == 0.0


def test_load_ends_with_a_pick_that_fails_in_the_check():
    loads: list[float] = []
    held = HeldLoad(holding_robot(loads), "can", 1.5, 0.6)
    for time in (1.0, 1.0 + LOAD_DELAY_S):
        held.update(cycle("check", time))
    assert loads[-1] > 0.0
    held.end()
    assert loads[-1] == 0.0


def test_load_pulls_a_simulated_object_down():
    robot = SimRobot(GraspWorld.build([can_on_table(0)]))
    body, still = robot.model.body("can").id, np.zeros(len(robot.joints))
    assert robot.mass("can") == pytest.approx(robot.model.body_mass[body])
    # Upwards with twice its weight: it rises off the table, and falls again without the load.
    robot.set_load("can", -2 * robot.mass("can") * GRAVITY)
    before = robot.object_pose("can").translation[2]
    for _ in range(25):
        robot.step(still)
    risen = robot.object_pose("can").translation[2]
    assert risen - before == pytest.approx(0.5 * GRAVITY * 0.1**2, rel=0.15)
    robot.set_load("can", 0.0)
    for _ in range(100):
        robot.step(still)
    assert robot.object_pose("can").translation[2] < before + 0.002
