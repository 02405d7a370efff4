"""The servo on a curved fingertip presses along the contact's normal, and backs off along it."""

import numpy as np
import pytest

from eyehand.tactile import (
    PRESETS,
    ContactFeatures,
    FeatureOptions,
    ServoGoal,
    TactileArray,
    TactileImage,
    TactileServo,
    TouchPhases,
    contact_features,
)

TIP = TactileArray.fingertip()
STIFFNESS, DT, LAG = 1e6, 0.004, 0.015


class Plate:
    """A rigid plate that a fingertip with 12 tactels meets at an angle."""

    def __init__(self, normal: np.ndarray) -> None:
        self.normal = normal / np.linalg.norm(normal)  # from the fingertip into the plate
        self.place, self.velocity, self.waiting = np.zeros(3), np.zeros(3), np.zeros(3)
        self.surface = float((TIP.positions @ self.normal).max()) + 0.0005
        self.rng = np.random.default_rng(0)

    def pressures(self) -> np.ndarray:
        """Return the true pressures, (12,), Pa: independent springs."""
        depth = (TIP.positions + self.place) @ self.normal - self.surface
        facing = np.maximum(TIP.normals @ self.normal, 0.0)
        # The pad has a soft skin of 2 mm, so that neighbours touch too.
        return STIFFNESS * facing * np.maximum(depth + 0.0005, 0.0)

    def features(self) -> ContactFeatures:
        """Return the features of a noisy image."""
        noisy = self.pressures() + self.rng.normal(0.0, 3.0, 12)
        image = TactileImage(np.maximum(noisy, 0.0), TIP)
        return contact_features(image, 20.0, options=FeatureOptions(min_tactels=1))

    def step(self, twist: np.ndarray) -> None:
        """Move for a cycle with the lag of an arm."""
        command, self.waiting = self.waiting, twist[:3]
        self.velocity += (1 - np.exp(-DT / LAG)) * (command - self.velocity)
        self.place += DT * self.velocity


@pytest.mark.parametrize("angle", [0.0, 25.0, 45.0])
@pytest.mark.parametrize("side", [0.0, 30.0])
def test_fingertip_presses_along_the_contact_and_backs_off(angle, side):
    a, b = np.radians([angle, side])
    plate = Plate(np.array([np.sin(b) * np.cos(a), np.sin(a), np.cos(b) * np.cos(a)]))
    phases = TouchPhases(TactileServo(ServoGoal(pressure=300.0), PRESETS["press"]))
    landed, path, cycles_in_task = np.zeros(3), [], 0
    for cycle in range(1500):
        features = plate.features()
        step = phases.step(features, DT)
        cycles_in_task += phases.phase == "task"
        # The approach along z has stopped after a few time constants of the arm.
        if cycles_in_task == 12:
            landed = plate.place.copy()
            phases.servo.goal = ServoGoal(pressure=600.0)
        path.append(plate.place.copy())
        plate.step(step.twist)
        if cycle == 1000:
            assert phases.phase == "task"
            assert features.pressure == pytest.approx(600.0, rel=0.1)
            # The columns are 50° apart, so the mean normal of a contact is exact to a third of it.
            moved = plate.place - landed
            assert np.linalg.norm(moved) > 2e-4
            assert moved @ plate.normal > np.cos(np.radians(17.0)) * np.linalg.norm(moved)
            phases.finish()
        if step.phase == "ended":
            break
    assert (phases.phase, phases.outcome) == ("ended", "done")
    assert not plate.pressures().any()
    away = plate.place - path[1000]
    assert away @ plate.normal < -0.5 * np.linalg.norm(away)


def test_flat_array_is_servoed_as_before():
    servo = TactileServo(ServoGoal(pressure=300.0))
    image = TactileImage(np.where(np.arange(256) == 100, 500.0, 0.0), TactileArray.flat())
    features = contact_features(image, 10.0)
    assert features.normal.tolist() == [0.0, 0.0, 1.0]
    twist = servo.step(features, DT).twist
    assert twist[2] < 0.0
    assert np.sign(twist[:2]).tolist() == np.sign(features.centre[:2]).tolist()
