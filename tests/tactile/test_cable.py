"""The cable follower: the line fit against NumPy, and curved cables in a closed loop."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import KDTree

from eyehand.errors import InputError
from eyehand.tactile import TactileArray, TactileImage, contact_features
from eyehand.tactile.cable import MIN_SHARE, CableFollower, CableOptions, fit_line
from eyehand.tactile.selection import CABLE, PRESS
from eyehand.tactile.servo import TactileServo

from .closed_loop import DT, World

PAD = TactileArray.flat()


def imprint(angle: float, offset: float, slope: float, bend: float) -> TactileImage:
    x, y = PAD.positions[:, 0], PAD.positions[:, 1]
    u, w = np.cos(angle) * x + np.sin(angle) * y, -np.sin(angle) * x + np.cos(angle) * y
    gap = w - (offset + slope * u + bend * u * u)
    return TactileImage(800.0 * np.exp(-0.5 * (gap / 0.004) ** 2), PAD)


@given(
    angle=st.floats(0.0, 3.14), offset=st.floats(-0.008, 0.008), slope=st.floats(-0.3, 0.3),
    bend=st.floats(-6.0, 6.0),
)  # fmt: skip
def test_fit_line_recovers_pressed_parabola(angle, offset, slope, bend):
    fit = fit_line(imprint(angle, offset, slope, bend), angle, 0.5)
    assert fit
    assert fit.offset == pytest.approx(offset, abs=4e-4)
    assert fit.slope == pytest.approx(slope, abs=0.04)
    assert fit.bend == pytest.approx(bend, abs=2.0)
    assert fit.ahead > 0.03


def test_fit_line_equals_weighted_least_squares():
    rng = np.random.default_rng(0)
    image = TactileImage(np.maximum(rng.normal(0.0, 300.0, 256), 0.0), PAD)
    fit = fit_line(image, 0.7, 50.0, reach=0.03)
    x, y = PAD.positions[:, 0], PAD.positions[:, 1]
    u, w = np.cos(0.7) * x + np.sin(0.7) * y, -np.sin(0.7) * x + np.cos(0.7) * y
    floor = MIN_SHARE * image.pressures.max()
    weight = np.maximum(image.pressures - floor, 0.0) * np.maximum(1.0 - (u / 0.03) ** 2, 0.0) ** 2
    bend, slope, offset = np.polyfit(u, w, 2, w=np.sqrt(weight))
    assert [fit.offset, fit.slope, fit.bend] == pytest.approx([offset, slope, bend], rel=1e-6)


def test_offset_of_fit_line_has_no_bias_from_curvature():
    image = imprint(np.pi / 2, 0.0, 0.0, 8.0)
    assert abs(contact_features(image, 1.0).centre[0]) > 0.002
    assert abs(fit_line(image, np.pi / 2, 1.0).offset) < 0.0003


def test_fit_line_returns_none_for_too_few_tactels():
    assert not fit_line(TactileImage(np.zeros(256), PAD), 0.0, 10.0)
    few = np.zeros(256)
    few[120:123] = 500.0
    assert not fit_line(TactileImage(few, PAD), 0.0, 10.0)
    one_row = np.zeros(256)
    one_row[::16] = 500.0
    across = fit_line(TactileImage(one_row, PAD), 0.0, 10.0)
    assert not across, "the tactels span no length along u"
    follower = CableFollower()
    assert not follower.step(TactileImage(np.zeros(256), PAD), 0.3).any()
    assert follower.at_end


def test_follower_reports_end_of_line():
    y = PAD.positions[:, 1]
    image = imprint(np.pi / 2, 0.0, 0.0, 0.0)
    follower = CableFollower()
    follower.step(image, np.pi / 2)
    assert not follower.at_end
    follower.step(TactileImage(np.where(y < 0.002, image.pressures, 0.0), PAD), np.pi / 2)
    assert follower.at_end


def test_follower_turns_to_line_direction_before_it_moves_forward():
    follower = CableFollower()
    twist = follower.step(imprint(0.2, 0.0, 0.0, 0.0), 0.2)
    assert twist[5] < -0.5
    assert np.hypot(*twist[:2]) < 1e-3


def wave(y):
    ramp = np.clip((y + 0.02) / 0.1, 0.0, 1.0)
    return 0.03 * np.sin(2 * np.pi * y / 0.25) * ramp**2 * (3.0 - 2.0 * ramp)


@pytest.mark.parametrize(("speed", "rms"), [(0.05, 0.0005), (0.1, 0.0006), (0.2, 0.0008)])
def test_follower_tracks_curved_cable(speed, rms):
    """A sine of amplitude 30 mm and period 250 mm has a radius of 53 mm at its crests.

    Earlier versions reached 0.36 to 1.23 mm rms.
    """
    errors, _ = follow(speed, CableFollower(CableOptions(speed=speed)))
    assert np.sqrt(np.mean(errors**2)) < rms


def test_servo_without_follower_is_biased_by_curvature():
    errors, _ = follow(0.05, None)
    assert np.sqrt(np.mean(errors**2)) > 0.0015


def test_cable_options_reject_invalid_values():
    with pytest.raises(InputError, match="heading"):
        CableOptions(heading=float("nan"))
    with pytest.raises(InputError, match="speed"):
        CableOptions(speed=float("inf"))


def follow(speed, follower):
    """Return the distances of the pad's centre from the path, m, and the world.

    Without a follower, the servo uses the chapter's cable selection.
    """
    y = np.linspace(-0.3, 0.6, 20001)
    tree, radius = KDTree(np.column_stack([wave(y), y])), 0.003

    def cable(x, y):
        gap = np.minimum(
            tree.query(np.column_stack([x, y]), distance_upper_bound=radius)[0], radius
        )
        return np.where(gap < radius, radius - np.sqrt(radius**2 - gap**2), np.inf)

    world = World(cable, position=np.array([0.003, -0.05, -0.001]), noise=3.0, threshold=15.0)
    servo = TactileServo(selection=PRESS if follower else CABLE)
    errors, landed = [], False
    for _ in range(round(0.32 / speed / DT)):
        image = world.image()
        features = contact_features(image, world.threshold)
        landed = landed or bool(features)
        outer = np.array([0.0, speed, 0.0, 0.0, 0.0, 0.0])
        if follower and features:
            outer = follower.step(image, features.orientation)
        twist = servo.step(features, DT, outer if landed else np.eye(6)[2] * 0.01).twist
        world.step(twist)
        if errors or world.position[1] > -0.03:
            errors.append(tree.query(world.position[:2])[0])
    return np.array(errors), world
