"""Closing two jaws by width alone, and by width and effort."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.grasping import GripOptions, JawCommand, JawReading, load_hand
from eyehand.grasping.hands import HandCommand, HandReading
from eyehand.grasping.hands.jaw_closing import JawClosing, grip_force
from eyehand.grasping.hands.jaw_control import JawControl

HAND = load_hand("panda")
DT = 0.01
SPEED = 0.1


@dataclass
class Jaws:
    """Ideal jaws around an object of a width, m; 0 for none."""

    object_width: float = 0.0
    effort: bool = True
    stalled: bool = False
    width: float = HAND.stroke
    force: float = 0.0
    speed: float = SPEED
    noise: float = 0.0
    """Standard deviation of the readings of the width, m."""

    def __post_init__(self):
        self.rng = np.random.default_rng(0)

    def read(self) -> JawReading:
        """Return the reading."""
        width = self.width + self.noise * self.rng.normal()
        return JawReading(width, self.force if self.effort else None)

    def move(self, command: JawCommand) -> None:
        """Follow a command for one period."""
        if self.stalled:
            return
        goal = max(command.width, self.object_width)
        self.width = max(goal, self.width - self.speed * DT)
        self.force = command.force if self.width == self.object_width else 0.0


def close(jaws: Jaws, seconds: float = 3.0, load: float | None = 0.1) -> JawClosing:
    closing = JawClosing(HAND, GripOptions(load=load))
    for _ in range(round(seconds / DT)):
        jaws.move(closing.step(jaws.read(), DT))
    return closing


@pytest.mark.parametrize("effort", [True, False])
@pytest.mark.parametrize("width", [0.004, 0.04, 0.075])
def test_width_that_stops_closing_is_contact_and_is_held(width, effort):
    closing = close(Jaws(width, effort))
    assert closing.state == "holding"
    assert closing.touched


@pytest.mark.parametrize("effort", [True, False])
@pytest.mark.parametrize("speed", [0.1, 0.02])
def test_noise_of_the_width_is_no_motion(speed, effort):
    """The noise is above the change of the width that counts as motion."""
    jaws = Jaws(0.04, effort, speed=speed, noise=6e-4)
    closing = close(jaws)
    assert closing.state == "holding"
    assert jaws.width == 0.04, "the jaws are held after they have closed"


@pytest.mark.parametrize("effort", [True, False])
def test_closed_jaws_are_empty(effort):
    closing = close(Jaws(0.0, effort))
    assert closing.state == "empty"
    assert not closing.touched


@pytest.mark.parametrize("effort", [True, False])
def test_jaws_that_do_not_move_are_stalled(effort):
    assert close(Jaws(0.04, effort, stalled=True)).state == "stalled"


def test_effort_without_motion_is_no_contact():
    """A gripper whose measured width stays at the stroke; it held objects, and let go too high."""
    closing = JawClosing(HAND, GripOptions(load=0.1))
    for _ in range(300):
        closing.step(JawReading(HAND.stroke, 20.0), DT)
    assert closing.state == "stalled"


def test_width_that_falls_to_empty_is_lost():
    jaws = Jaws(0.04)
    closing = close(jaws)
    jaws.object_width = 0.0
    for _ in range(60):
        jaws.move(closing.step(jaws.read(), DT))
    assert closing.state == "empty"
    assert not JawControl(HAND).holds(jaws.read())


def test_force_follows_load_within_range_of_gripper():
    light, heavy, unknown = (grip_force(HAND, GripOptions(load=m)) for m in (0.01, 2.0, None))
    assert light == 20.0
    assert light < heavy < unknown == HAND.force[1]
    # Half the weight on each pad, by friction: 2 µ F = safety m g.
    assert heavy == pytest.approx(3.0 * 2.0 * 9.81 / (2 * 0.6))
    # A load beside the closing axis turns between pads that resist at 0.4 of their smaller side.
    beside = grip_force(HAND, GripOptions(load=1.0, lever=0.4 * HAND.pad_width))
    assert beside == pytest.approx(heavy)


def test_reading_of_another_kind_of_hand_is_refused():
    control = JawControl(HAND)
    zeros = np.zeros(2)
    other = HandReading(zeros, zeros, zeros, zeros, ())
    with pytest.raises(InputError, match="JawReading, got HandReading"):
        control.width(other)
    assert not isinstance(control.opened(), HandCommand)
