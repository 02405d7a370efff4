"""Seeking by touch: down the imprint's area, along edges, to corners, and to a stop."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import ContactFeatures, TactileImage, contact_features
from eyehand.tactile.area_slope import AreaSlope
from eyehand.tactile.contour_follower import ContourFollower
from eyehand.tactile.contour_options import ContourOptions
from eyehand.tactile.selection import PRESS
from eyehand.tactile.servo import TactileServo

from .closed_loop import DT, PAD, World, box, rod

NOTHING = ContactFeatures(0.0, np.zeros(3), 0.0, 0.0, 0.0, 0.0)
EVEN = TactileImage(np.full(256, 1000.0), PAD)
"""A face that goes on beyond the pad everywhere."""


def explore(height, options, stiffness=5e6, seconds=60.0):
    """Spots in the world, (kind, (2,) m), how the guide ended, and the largest pressure."""
    world = World(height, stiffness, place=np.array([0, 0, -0.001]), noise=3.0, threshold=15.0)
    servo, guide = TactileServo(selection=PRESS), ContourFollower(options)
    spots, peak, landed = [], 0.0, False
    for _ in range(round(seconds / DT)):
        image = world.image()
        features = contact_features(image, world.threshold)
        landed = landed or bool(features)
        outer = np.array([0.0, 0.0, 0.01, 0.0, 0.0, 0.0])
        if landed:
            found = guide.step(features, image, DT)
            outer = found.twist
            if found.point:
                place = world.place + world.rotation.apply(found.point.position)
                spots.append((found.point.kind, place[:2]))
            if found.state == "ended":
                return spots, guide, peak
        world.step(servo.step(features, DT, outer).twist)
        peak = max(peak, features.pressure)
    raise AssertionError("never ended")


def turned(height, angle):
    """The same object, turned about the world's z."""
    c, s = np.cos(angle), np.sin(angle)
    return lambda x, y: height(c * x + s * y, -s * x + c * y)


def turn_back(place, angle):
    """A place in the frame of an object that is turned so."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) @ place


@pytest.mark.parametrize(("heading", "angle"), [(0.3, 0.0), (2.2, 0.6)])
def test_the_rim_of_a_box_is_found_and_followed_all_round(heading, angle):
    options = ContourOptions(heading=heading, speed=0.08)
    spots, guide, peak = explore(turned(box(0.065, 0.05), angle), options)
    assert guide.outcome == "round"
    assert [kind for kind, _ in spots] == ["edge", *["corner"] * 4]
    places = [turn_back(place, angle) for _, place in spots[1:]]
    assert len({tuple(np.sign(place)) for place in places}) == 4
    for place in places:
        assert np.allclose(np.abs(place), [0.065, 0.05], atol=0.0015)
    assert peak < 2000.0


def test_an_edge_that_turns_outwards_has_an_inner_corner():
    arm, other = box(0.09, 0.04), box(0.04, 0.09)

    def cross(x, y):
        return np.minimum(arm(x, y), other(x, y))

    spots, guide, _ = explore(turned(cross, 0.3), ContourOptions(speed=0.08, max_points=7))
    assert guide.outcome == "done"
    kinds = [kind for kind, _ in spots[1:]]
    inner = [number for number, kind in enumerate(kinds) if kind == "inner_corner"]
    assert len(inner) == 2
    assert inner[1] - inner[0] == 3, "two corners of an arm between them"
    for kind, place in spots[1:]:
        size = np.sort(np.abs(turn_back(place, 0.3)))
        assert np.allclose(size, [0.04, 0.04 if kind == "inner_corner" else 0.09], atol=0.002)


def test_a_round_face_has_no_corner():
    def disc(x, y):
        return np.where(np.hypot(x, y) < 0.065, 0.0, np.inf)

    spots, guide, _ = explore(disc, ContourOptions(speed=0.08))
    assert guide.outcome == "round"
    assert [kind for kind, _ in spots] == ["edge"]


def test_a_pad_that_does_not_move_as_asked_is_told():
    guide = ContourFollower()
    contact = ContactFeatures(1.0, np.zeros(3), 1000.0, 6e-3, 0.0, 0.1)
    steps = [guide.step(contact, EVEN, DT, np.zeros(6)) for _ in range(300)]
    assert steps[-1].outcome == "blocked"
    assert not steps[-1].twist.any()


def test_a_ridge_is_followed_to_both_its_ends():
    whole = rod(0.005, 0.5)

    def piece(x, y):
        along = np.cos(0.5) * x + np.sin(0.5) * y
        return np.where(np.abs(along) < 0.07, whole(x, y), np.inf)

    spots, guide, _ = explore(piece, ContourOptions(speed=0.05), 1e12)
    assert guide.outcome == "done"
    assert [kind for kind, _ in spots] == ["ridge", "end", "end"]
    ends = 0.07 * np.array([np.cos(0.5), np.sin(0.5)])
    assert np.allclose(spots[1][1], ends, atol=0.0015)
    assert np.allclose(spots[2][1], -ends, atol=0.0015)


def test_on_an_endless_face_the_search_is_bounded():
    options = ContourOptions(travel=0.1, speed=0.1)
    spots, guide, _ = explore(box(2.0, 2.0), options)
    assert guide.outcome == "nothing_found"
    assert not spots


def test_without_contact_it_rests_and_gives_up():
    guide = ContourFollower()
    steps = [guide.step(NOTHING, EVEN, DT) for _ in range(800)]
    assert not any(step.twist.any() for step in steps)
    assert steps[-1].outcome == "lost"


def test_time_is_bounded_too():
    guide = ContourFollower(ContourOptions(seconds=0.5, travel=10.0))
    round_contact = ContactFeatures(1.0, np.zeros(3), 1000.0, 1e-3, 0.0, 0.1)
    steps = [guide.step(round_contact, EVEN, DT) for _ in range(200)]
    assert steps[-1].outcome == "out_of_time"
    assert not steps[-1].twist.any()


@pytest.mark.parametrize("downhill", [0.5, 2.5, -2.0])
def test_seeking_turns_to_where_the_imprint_shrinks(downhill):
    rng = np.random.default_rng(0)
    guide, place = ContourFollower(ContourOptions(heading=0.0)), np.zeros(2)
    way = np.array([np.cos(downhill), np.sin(downhill)])
    start = np.zeros(2)
    for cycle in range(round(8.0 / DT)):
        area = 2e-3 - 5e-3 * float(place @ way) + rng.normal(0.0, 2.5e-5)
        contact = ContactFeatures(1.0, np.zeros(3), 1000.0, area, 0.0, 0.1)
        twist = guide.step(contact, EVEN, DT).twist
        place = place + twist[:2] * DT
        if cycle == round(4.0 / DT):
            start = place
    gone = place - start
    assert float(gone @ way) > 0.85 * np.linalg.norm(gone)


def test_the_slope_of_a_plane_is_found_and_a_straight_way_has_none():
    rng, slope = np.random.default_rng(0), AreaSlope(0.03)
    straight, found, place = AreaSlope(0.03), None, np.zeros(2)
    for _ in range(200):
        way = rng.normal(0.0, 0.003, 2)
        place = place + way
        slope.move(way)
        found = slope.update(1e-3 + 0.02 * place[0] - 0.01 * place[1])
        straight.move(np.array([0.001, 0.0005]))
        assert straight.update(rng.uniform(0, 1e-3)) is None
    assert found is not None
    assert found == pytest.approx([0.02, -0.01], rel=1e-3)


def test_impossible_options_are_refused():
    with pytest.raises(InputError, match="heading"):
        ContourOptions(heading=float("inf"))
    with pytest.raises(InputError, match="travel"):
        ContourOptions(travel=float("inf"))
    with pytest.raises(InputError, match="max_points"):
        ContourOptions(max_points=0)
