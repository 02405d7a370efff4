"""The grip on a held object follows the load, its friction, and slip."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.grasping.hands import GripOptions, HandReading
from eyehand.grasping.hands.closing import Closing
from eyehand.grasping.hands.grip_regulator import GripRegulator
from eyehand.grasping.held_grip import (
    GRAVITY,
    STEADY_SECONDS,
    HeldGrip,
    measured_wrench,
)
from eyehand.grasping.robot import RobotReading

from .fake_robot import HAND, PERIOD

OFFSETS = HAND.row_offsets
SLACK = 8.0
"""Tension of a finger that presses with no force, N."""


class HeldObject:
    """An object between three fingertips and the thumb, which slides beyond its friction."""

    def __init__(self, mass: float, friction: float):
        self.mass, self.friction = mass, friction
        self.closing = Closing(HAND, "precision", 0.06, GripOptions())
        self.time, self.speed, self.slid, self.load_factor = 0.0, 0.0, 0.0, 1.0
        self.share = self.push = self.torque = 0.0
        self.lifted, self.measures = False, True
        self.lost: np.ndarray | None = None
        contact = self.hand_reading(10.0)
        for _ in range(800):
            self.closing.step(contact, PERIOD)
        assert self.closing.state == "holding"
        self.held = HeldGrip(self.closing, False, OFFSETS, np.zeros(6), 0.09)
        palm = np.diag([1.0, -1.0, -1.0])
        self.cell: Any = SimpleNamespace(
            robot=SimpleNamespace(period=PERIOD),
            hand=SimpleNamespace(holds=lambda _: True, forces=lambda _: self.forces()),
            arm_state=lambda: SimpleNamespace(rotation=palm, jacobian=np.zeros((6, 7))),
        )

    def side(self) -> float:
        """Return the force of fingers, and of the thumb, N."""
        return max(3.0 * (self.closing.tension - SLACK) / 15.0, 0.0)

    def forces(self) -> np.ndarray:
        """Return the forces of fingers, thumb and palm, (5,), N."""
        side = self.side()
        return np.array([side / 3, side / 3, side / 3, side, 0.0])

    def hand_reading(self, force: float) -> HandReading:
        """Return the reading of a hand with a force on every fingertip, N."""
        forces = np.array([force if pad.endswith("distal") else 0.0 for pad in HAND.pads])
        excursions = HAND.excursions_at(0.06)
        count = len(HAND.drives)
        return HandReading(excursions, np.zeros(count), np.zeros(len(HAND.joints)), forces, ())

    def step(self) -> None:
        """Simulate one control period."""
        self.time += PERIOD
        # A rising hand takes over the weight from the table in 0.15 s.
        self.share = min(self.share + PERIOD / 0.15, 1.0) if self.lifted else 0.0
        weight = self.share * self.mass * GRAVITY * self.load_factor
        most = 2.0 * self.friction * self.side()
        sliding = self.speed > 0.0 or weight > most
        carried = min(weight, most) if sliding else weight
        self.speed = max(self.speed + PERIOD * (weight - most) / self.mass, 0.0) if sliding else 0.0
        self.slid += PERIOD * self.speed
        wrench = (
            np.array([0.0, 0.0, carried - self.push, self.torque, 0.0, 0.0])
            if self.measures
            else self.lost
        )
        reading = RobotReading(
            self.time, np.zeros(7), np.zeros(7), self.hand_reading(self.side()), wrench=wrench
        )
        self.held.update(self.cell, reading)

    def run(self, seconds: float) -> None:
        """Simulate a time, s."""
        for _ in range(round(seconds / PERIOD)):
            self.step()

    def pull(self) -> None:
        """Lift, weigh, and ease the grip."""
        self.lifted = True
        self.run(0.4)
        assert self.held.steady
        self.held.weigh()
        self.held.start_pull(2.0 * self.side())
        self.run(1.5)
        assert not self.held.pulling


@pytest.mark.parametrize("mass", [0.15, 0.4, 1.2])
def test_weight_is_measured_within_two_percent(mass):
    held = HeldObject(mass, 1.0)
    held.lifted = True
    held.run(0.4)
    held.held.weigh()
    assert held.held.weight == pytest.approx(mass * GRAVITY, rel=0.02)


@pytest.mark.parametrize("mass", [0.15, 0.4, 1.2])
@pytest.mark.parametrize("friction", [0.3, 0.6, 1.0])
def test_grip_holds_any_friction_with_little_more_than_it_needs(mass, friction):
    held = HeldObject(mass, friction)
    held.pull()
    held.run(1.0)
    needed = mass * GRAVITY / friction
    assert held.slid < 0.01
    assert held.speed == 0.0
    assert needed < 2.0 * held.side() < 2.6 * needed + 8.0
    if held.held.friction is not None:
        assert held.held.friction == pytest.approx(friction, rel=0.15)


@pytest.mark.parametrize("torque", [0.0, 0.05])
def test_object_that_stops_turning_stays_in_the_hand(torque):
    """Turning, it stuck at a ratio of 0.6, where the pads had a friction of 0.3."""
    held = HeldObject(0.17, 0.3)
    held.torque = torque
    held.pull()
    held.torque = 0.0
    slid = held.slid
    held.run(1.5)
    assert held.slid == slid
    assert 2.0 * held.side() > 1.1 * held.mass * GRAVITY / held.friction


def test_neighbour_that_presses_the_thumb_does_not_open_the_grip():
    """A thumb that read 21 N took the tension from the fingers, and a wall of 0.2 kg fell."""
    held = HeldObject(0.2, 1.0)
    held.pull()
    held.run(0.5)
    exact, slid = held.forces, held.slid
    held.cell.hand.forces = lambda _: exact() + np.array([0.0, 0.0, 0.0, 20.0, 0.0])
    held.run(0.5)
    assert held.slid == slid


def test_grip_follows_an_added_load_without_losing_the_object():
    held = HeldObject(0.4, 0.6)
    held.pull()
    held.run(1.0)
    before, slid = held.side(), held.slid
    held.load_factor = 1.5
    held.run(0.5)
    assert held.speed == 0.0
    assert held.slid - slid < 0.005
    assert held.side() > 1.2 * before


def test_slip_raises_the_grip_and_corrects_the_weight():
    held = HeldObject(0.4, 0.6)
    held.pull()
    held.run(1.0)
    before = held.side()
    held.load_factor = 0.5
    held.run(5 * STEADY_SECONDS)
    assert 1 <= held.held.slips < 6
    assert held.held.weight < 0.75 * 0.4 * GRAVITY
    assert held.side() > before


@pytest.mark.parametrize("push", [6.0, 40.0])
def test_object_that_a_support_pushes_up_is_not_squeezed_as_if_it_slipped(push):
    """The push grew the grip to 216 N, and pressed objects out of the hand."""
    held = HeldObject(0.15, 0.6)
    held.pull()
    held.run(1.0)
    before, weight, slips = held.side(), held.held.weight, held.held.slips
    held.push = push
    held.run(0.5)
    assert held.side() < 1.3 * before
    assert (held.held.weight, held.held.slips) == (weight, slips)
    assert held.held.pushed == pytest.approx(push - 0.15 * GRAVITY, rel=0.05)


def test_regulator_tightens_at_a_limited_rate_and_never_eases():
    held = HeldObject(0.4, 0.6)
    regulator, start = GripRegulator(held.closing), held.closing.tension
    regulator.tighten(1.0, PERIOD)
    assert held.closing.tension == start
    regulator.tighten(60.0, PERIOD)
    assert start < held.closing.tension < start + 3.0
    for _ in range(200):
        regulator.tighten(60.0, PERIOD)
    assert held.closing.tension == pytest.approx(150.0)
    regulator.tighten(1000.0, 10.0)
    assert held.closing.tension == GripOptions().max_tension


@pytest.mark.parametrize("force", [5.0, 20.0, 40.0])
def test_regulator_reaches_the_wanted_force(force):
    held = HeldObject(0.4, 0.6)
    regulator = GripRegulator(held.closing)
    for _ in range(250):
        regulator.press(force, 2.0 * held.side(), PERIOD)
    assert 2.0 * held.side() == pytest.approx(force, rel=0.02)


def test_late_pads_do_not_let_go_while_the_grip_is_relaxed():
    held = HeldObject(0.06, 0.3)
    regulator, force = GripRegulator(held.closing), 2.0 * held.side()
    felt, goal, lowest = force, force, 1.0
    for _ in range(300):
        felt += (2.0 * held.side() - felt) * PERIOD / 0.04
        goal += (4.4 - goal) * PERIOD / 0.2
        regulator.press(goal, felt, PERIOD)
        lowest = min(lowest, 2.0 * held.side() / goal)
    assert lowest > 0.8
    assert 2.0 * held.side() == pytest.approx(4.4, abs=0.3)


def test_carry_uses_at_least_the_usual_tension():
    held = HeldObject(0.15, 1.0)
    held.pull()
    held.run(1.0)
    usual = held.closing.grip_tension
    assert held.closing.tension < usual
    held.held.carrying = True
    held.run(0.2)
    assert held.closing.tension == usual


@pytest.mark.parametrize("lost", [None, np.full(6, np.nan)])
def test_lost_wrist_sensor_restores_the_usual_tension(lost):
    held = HeldObject(0.15, 1.0)
    held.pull()
    held.run(1.0)
    assert held.closing.tension < held.closing.grip_tension
    held.measures, held.lost = False, lost
    held.run(0.3)
    assert held.closing.tension == held.closing.grip_tension
    assert np.isfinite(held.held.load).all()


def test_wrench_of_another_shape_is_refused():
    reading = RobotReading(
        0.0, np.zeros(7), np.zeros(7), HeldObject(0.4, 0.6).hand_reading(1.0), wrench=np.zeros(3)
    )
    with pytest.raises(InputError, match=r"wrench must have shape \(6,\), got \(3,\)"):
        measured_wrench(reading)
