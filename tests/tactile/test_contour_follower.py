"""The contour follower: search for an edge, follow it, detect corners, and stop."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import (
    ContactFeatures,
    TactileImage,
    contact_features,
    contour_follower,
    contour_progress,
)
from eyehand.tactile.area_slope import AreaSlope
from eyehand.tactile.contour_follower import ContourFollower
from eyehand.tactile.contour_progress import ContourOptions
from eyehand.tactile.selection import PRESS
from eyehand.tactile.servo import TactileServo

from .closed_loop import DT, PAD, World, box, rod

NO_CONTACT = ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
EVEN = TactileImage(np.full(256, 1000.0), PAD)
"""The image of a face that is larger than the pad."""


def explore(height, options, stiffness=5e6, seconds=60.0):
    """Explore the object. Return the points (kind, (2,) m), the follower and the peak pressure."""
    world = World(height, stiffness, position=np.array([0, 0, -0.001]), noise=3.0, threshold=15.0)
    servo, follower = TactileServo(selection=PRESS), ContourFollower(options)
    points, peak, landed = [], 0.0, False
    for _ in range(round(seconds / DT)):
        image = world.image()
        features = contact_features(image, world.threshold)
        landed = landed or bool(features)
        outer = np.array([0.0, 0.0, 0.01, 0.0, 0.0, 0.0])
        if landed:
            found = follower.step(features, image, DT)
            outer = found.twist
            if found.point:
                position = world.position + world.rotation.apply(found.point.position)
                points.append((found.point.kind, position[:2]))
            if found.state == "ended":
                return points, follower, peak
        world.step(servo.step(features, DT, outer).twist)
        peak = max(peak, features.pressure)
    raise AssertionError("never ended")


def rotated(height, angle):
    """Return the height field rotated about the world's z-axis by ``angle``, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return lambda x, y: height(c * x + s * y, -s * x + c * y)


def to_object_frame(position, angle):
    """Return a point of the world in the frame of an object rotated by ``angle``."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) @ position


@pytest.mark.parametrize(("heading", "angle"), [(0.3, 0.0), (2.2, 0.6)])
def test_follower_traces_whole_contour_of_box(heading, angle):
    options = ContourOptions(heading=heading, speed=0.08)
    points, follower, peak = explore(rotated(box(0.065, 0.05), angle), options)
    assert follower.outcome == "closed"
    assert [kind for kind, _ in points] == ["edge", *["corner"] * 4]
    positions = [to_object_frame(position, angle) for _, position in points[1:]]
    assert len({tuple(np.sign(position)) for position in positions}) == 4
    for position in positions:
        assert np.allclose(np.abs(position), [0.065, 0.05], atol=0.0015)
    assert peak < 2000.0


def test_concave_contour_has_inner_corners(monkeypatch):
    arm, other = box(0.09, 0.04), box(0.04, 0.09)

    def cross(x, y):
        return np.minimum(arm(x, y), other(x, y))

    monkeypatch.setattr(contour_follower, "MAX_POINTS", 7)
    points, follower, _ = explore(rotated(cross, 0.3), ContourOptions(speed=0.08))
    assert follower.outcome == "done"
    kinds = [kind for kind, _ in points[1:]]
    inner = [number for number, kind in enumerate(kinds) if kind == "inner_corner"]
    assert len(inner) == 2
    assert inner[1] - inner[0] == 3, "two outer corners lie between the inner corners"
    for kind, position in points[1:]:
        size = np.sort(np.abs(to_object_frame(position, 0.3)))
        assert np.allclose(size, [0.04, 0.04 if kind == "inner_corner" else 0.09], atol=0.002)


def test_round_contour_has_no_corners():
    def disc(x, y):
        return np.where(np.hypot(x, y) < 0.065, 0.0, np.inf)

    points, follower, _ = explore(disc, ContourOptions(speed=0.08))
    assert follower.outcome == "closed"
    assert [kind for kind, _ in points] == ["edge"]


def test_follower_reports_blocked_pad():
    follower = ContourFollower()
    contact = ContactFeatures(1.0, np.zeros(3), 1000.0, 6e-3, 0.0, 0.1)
    steps = [follower.step(contact, EVEN, DT, np.zeros(6)) for _ in range(300)]
    assert steps[-1].outcome == "blocked"
    assert not steps[-1].twist.any()


def test_ridge_is_followed_to_both_ends():
    endless_ridge = rod(0.005, 0.5)

    def ridge(x, y):
        along = np.cos(0.5) * x + np.sin(0.5) * y
        return np.where(np.abs(along) < 0.07, endless_ridge(x, y), np.inf)

    points, follower, _ = explore(ridge, ContourOptions(speed=0.05), 1e12)
    assert follower.outcome == "done"
    assert [kind for kind, _ in points] == ["ridge", "end", "end"]
    ends = 0.07 * np.array([np.cos(0.5), np.sin(0.5)])
    assert np.allclose(points[1][1], ends, atol=0.0015)
    assert np.allclose(points[2][1], -ends, atol=0.0015)


def test_search_on_unbounded_face_ends_after_travel_limit(monkeypatch):
    monkeypatch.setattr(contour_progress, "MAX_TRAVEL_M", 0.1)
    options = ContourOptions(speed=0.1)
    points, follower, _ = explore(box(2.0, 2.0), options)
    assert follower.outcome == "nothing_found"
    assert not points


def test_follower_without_contact_stays_and_ends_as_lost():
    follower = ContourFollower()
    steps = [follower.step(NO_CONTACT, EVEN, DT) for _ in range(800)]
    assert not any(step.twist.any() for step in steps)
    assert steps[-1].outcome == "lost"


def test_follower_ends_after_time_limit():
    follower = ContourFollower(ContourOptions(seconds=0.5))
    round_contact = ContactFeatures(1.0, np.zeros(3), 1000.0, 1e-3, 0.0, 0.1)
    steps = [follower.step(round_contact, EVEN, DT) for _ in range(200)]
    assert steps[-1].outcome == "limit_reached"
    assert not steps[-1].twist.any()


@pytest.mark.parametrize("downhill", [0.5, 2.5, -2.0])
def test_search_moves_towards_decreasing_contact_area(downhill):
    rng = np.random.default_rng(0)
    follower, position = ContourFollower(ContourOptions(heading=0.0)), np.zeros(2)
    direction = np.array([np.cos(downhill), np.sin(downhill)])
    start = np.zeros(2)
    for cycle in range(round(8.0 / DT)):
        area = 2e-3 - 5e-3 * float(position @ direction) + rng.normal(0.0, 2.5e-5)
        contact = ContactFeatures(1.0, np.zeros(3), 1000.0, area, 0.0, 0.1)
        twist = follower.step(contact, EVEN, DT).twist
        position = position + twist[:2] * DT
        if cycle == round(4.0 / DT):
            start = position
    travelled = position - start
    assert float(travelled @ direction) > 0.85 * np.linalg.norm(travelled)


def test_area_slope_recovers_gradient_and_is_none_on_straight_path():
    rng, slope = np.random.default_rng(0), AreaSlope(0.03)
    straight, found, position = AreaSlope(0.03), None, np.zeros(2)
    for _ in range(200):
        step = rng.normal(0.0, 0.003, 2)
        position = position + step
        slope.move(step)
        found = slope.update(1e-3 + 0.02 * position[0] - 0.01 * position[1])
        straight.move(np.array([0.001, 0.0005]))
        assert straight.update(rng.uniform(0, 1e-3)) is None
    assert found is not None
    assert found == pytest.approx([0.02, -0.01], rel=1e-3)


def test_contour_options_reject_invalid_values():
    with pytest.raises(InputError, match="heading"):
        ContourOptions(heading=float("inf"))
    with pytest.raises(InputError, match="seconds"):
        ContourOptions(seconds=float("inf"))
    with pytest.raises(InputError, match="speed"):
        ContourOptions(speed=0.0)
