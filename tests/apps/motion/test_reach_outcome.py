"""The result of a reach: reached, contact, stuck, late, or given up."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from eyehand.apps.motion.reach_outcome import STANDSTILL_S, ReachOptions, run_reach
from eyehand.data_synth.scenes import ArmClearance, make_reaching_scene
from eyehand.errors import InputError

EMPTY = make_reaching_scene(0, boxes=0)


def _to_witness(scene, gain: float = 2.0):
    def method(q):
        return gain * (scene.witness - q), ""

    return method


def test_straight_motion_reaches_the_goal_in_an_empty_scene():
    outcome = run_reach(EMPTY, _to_witness(EMPTY))
    assert outcome.success
    assert outcome.status == "reached"
    assert outcome.contacts == 0
    assert outcome.final_error < 1e-3
    assert outcome.min_clearance > 0
    assert len(outcome.cycle_times_us) == round(outcome.seconds / 0.005)
    assert (outcome.cycle_times_us > 0).all()


def test_reach_through_a_box_is_no_success():
    scene = next(
        scene
        for scene in map(make_reaching_scene, range(20))
        if run_reach(scene, _to_witness(scene)).contacts
    )
    outcome = run_reach(scene, _to_witness(scene))
    assert outcome.status == "reached"
    assert outcome.min_clearance < 0
    assert not outcome.success
    checker, q, contacts = ArmClearance(scene.obstacles), scene.start.copy(), 0
    for _ in outcome.cycle_times_us:
        q += 0.005 * 2.0 * (scene.witness - q)
        contacts += checker.at(q) < 0
    assert outcome.contacts == contacts


def test_arm_without_motion_is_stuck():
    outcome = run_reach(EMPTY, lambda q: (np.zeros_like(q), ""))
    assert outcome.status == "stuck"
    assert outcome.seconds == pytest.approx(STANDSTILL_S)
    assert not outcome.success


def test_arm_that_does_not_arrive_is_late():
    side = np.eye(7)[6] * 0.01
    outcome = run_reach(EMPTY, lambda q: (side, ""), ReachOptions(time_limit=1.5))
    assert outcome.status == "late"
    assert outcome.seconds == pytest.approx(1.5)


def test_oscillation_is_not_stuck():
    sign = 1.0

    def swing(q):
        nonlocal sign
        sign = -sign
        return np.full(7, 0.1 * sign), ""

    assert run_reach(EMPTY, swing, ReachOptions(time_limit=1.5)).status == "late"


def test_status_of_the_method_ends_the_run():
    outcome = run_reach(EMPTY, lambda q: (np.zeros_like(q), "infeasible"))
    assert outcome.status == "infeasible"
    assert outcome.seconds == pytest.approx(0.005)


@pytest.mark.parametrize("speed", [np.zeros(6), np.full(7, np.nan)])
def test_invalid_speeds_are_rejected(speed):
    with pytest.raises(InputError, match="7 finite joint speeds"):
        run_reach(EMPTY, lambda q: (speed, ""))


def test_cycle_time_of_zero_is_rejected():
    with pytest.raises(InputError, match="dt must be"):
        ReachOptions(dt=0.0)


def test_clearance_includes_the_start():
    blocked = dataclasses.replace(make_reaching_scene(1), start=make_reaching_scene(1).witness)
    outcome = run_reach(blocked, lambda q: (np.zeros_like(q), ""))
    assert outcome.status == "reached"
    assert outcome.min_clearance == ArmClearance(blocked.obstacles).at(blocked.start)
