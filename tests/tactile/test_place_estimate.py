"""The estimate of a contact's true place under shear."""

import numpy as np
import pytest

from eyehand.tactile.place_estimate import (
    MAX_FRICTION,
    PLACE_SIZE,
    SIDE_X,
    SIDE_Y,
    estimate_place,
    lose_place,
)

DT, LEVER, NORMAL = 0.004, 0.004, 2.0


class Contact:
    """A contact that slides over the pad, and the estimator."""

    def __init__(self, wait: int = 0) -> None:
        self.state, self.log = np.zeros(PLACE_SIZE), np.zeros((4, 50))
        self.wait, self.cycle = wait, 0
        self.places = [np.array([0.005, -0.003])]
        self.place = np.zeros(2)

    def run(self, cycles: int, speed: float, side: float = np.nan, shift: float = 0.0) -> None:
        """Slide the pad along x for some cycles; friction moves the centre by `shift`, m."""
        for _ in range(cycles):
            self.places.append(self.places[-1] - [speed * DT, 0.0])
            seen = self.places[max(len(self.places) - 1 - self.wait, 0)]
            centre = np.array([seen[0] + shift, seen[1], 0.0])
            self.state[SIDE_X : SIDE_Y + 1] = side, 0.0 * side
            motion = np.array([speed, 0.0, 0.0, 0.0, 0.0, 0.0])
            rule = (LEVER, float(self.wait), DT)
            estimate_place(
                self.state, self.log, self.cycle, centre, NORMAL, motion, rule, self.place
            )
            self.cycle += 1

    @property
    def error(self) -> float:
        """Distance of the estimate from the true place now, m."""
        return float(np.linalg.norm(self.place - self.places[-1]))


def test_contact_that_did_not_move_is_at_its_centre() -> None:
    contact = Contact()
    # The force sensor's noise must not enter before anything has slid.
    contact.run(20, 0.0, side=0.5)
    assert contact.error < 1e-12


def test_measured_force_removes_the_shift() -> None:
    contact = Contact()
    contact.run(5, 0.0, side=0.0)
    side = 0.8
    contact.run(200, 0.01, side=side, shift=LEVER * side / NORMAL)
    assert LEVER * side / NORMAL > 1e-3
    assert contact.error < 2e-5


def test_own_motion_alone_keeps_the_place_at_touch() -> None:
    contact = Contact()
    contact.run(5, 0.0)
    contact.run(200, 0.01, shift=-0.5 * LEVER)
    assert contact.error < 2e-5


def test_moved_object_is_followed_beyond_the_reach_of_friction() -> None:
    contact = Contact()
    contact.run(100, 0.01)
    contact.places.append(contact.places[-1] + [0.02, 0.0])
    contact.run(2000, 0.0)
    assert contact.error < 1.1 * MAX_FRICTION * LEVER


def test_moved_object_is_followed_if_force_is_measured() -> None:
    contact = Contact()
    contact.run(100, 0.01, side=0.0)
    contact.places.append(contact.places[-1] + [0.02, 0.0])
    contact.run(1000, 0.0, side=0.0)
    assert contact.error < 1e-4


def test_estimate_is_of_now_and_not_of_the_old_image() -> None:
    contact = Contact(wait=4)
    contact.run(10, 0.0, side=0.0)
    contact.run(100, 0.05, side=0.0)
    assert contact.error < 2e-5


def test_lost_contact_is_forgotten() -> None:
    contact = Contact()
    contact.run(10, 0.01, side=0.0)
    lose_place(contact.state)
    assert not contact.state[:SIDE_X].any()


def test_kernel_equals_its_formula() -> None:
    rng = np.random.default_rng(0)
    compiled, plain = np.zeros(PLACE_SIZE), np.zeros(PLACE_SIZE)
    logs, places = (np.zeros((4, 20)), np.zeros((4, 20))), (np.zeros(2), np.zeros(2))
    for cycle in range(60):
        side = rng.normal(0, 0.3, 2)
        compiled[SIDE_X : SIDE_Y + 1] = plain[SIDE_X : SIDE_Y + 1] = side
        centre = np.array([*rng.normal(0, 0.003, 2), 0.0])
        motion = rng.normal(0, 0.02, 6)
        force, rule = float(rng.uniform(0.1, 3)), (LEVER, 2.0, DT)
        estimate_place(compiled, logs[0], cycle, centre, force, motion, rule, places[0])
        estimate_place.py_func(plain, logs[1], cycle, centre, force, motion, rule, places[1])
        assert places[0] == pytest.approx(places[1], abs=1e-12)
