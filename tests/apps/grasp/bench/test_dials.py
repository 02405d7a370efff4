"""Named settings: every name gives options, and turns what it says."""

from __future__ import annotations

from dataclasses import replace

import pytest

from eyehand.apps.grasp.bench.dials import (
    CONTROL,
    DEFAULT,
    PERCEPTION,
    control_dial,
    perception_dial,
)
from eyehand.errors import InputError
from eyehand.grasping.pick_options import PickOptions
from eyehand.perception import PerceiveOptions, SegmentationOptions


def test_the_default_is_what_the_demo_has():
    usual = perception_dial(DEFAULT)
    assert replace(usual, segmentation=SegmentationOptions()) == PerceiveOptions()
    assert usual.segmentation.min_object < SegmentationOptions().min_object
    assert control_dial(DEFAULT) == PickOptions()


def test_every_name_gives_options_of_its_own():
    assert len({repr(perception_dial(name)) for name in PERCEPTION}) == len(PERCEPTION)
    assert len({repr(control_dial(name)) for name in CONTROL}) == len(CONTROL)


def test_fast_perception_looks_at_less_and_fine_at_more():
    fast, usual, fine = (perception_dial(name) for name in ("fast", DEFAULT, "fine"))
    assert fast.segmentation.stride > usual.segmentation.stride
    assert fast.fit.points < usual.fit.points < fine.fit.points
    assert fast.fit.starts < usual.fit.starts < fine.fit.starts


def test_a_slow_hand_has_more_time_and_a_fast_one_no_less():
    slow, usual, fast = (control_dial(name) for name in ("slow", DEFAULT, "fast"))
    assert slow.speed < usual.speed < fast.speed
    assert slow.time_limit(3.0) > usual.time_limit(3.0) == fast.time_limit(3.0)


def test_the_planner_dial_searches_longer_and_keeps_all_else():
    base = PickOptions(pre_grasp_distance=0.05)
    turned = control_dial("planner", base)
    assert turned.planner.rollouts > base.planner.rollouts
    assert turned.pre_grasp_distance == base.pre_grasp_distance


@pytest.mark.parametrize("dial", [perception_dial, control_dial])
def test_an_unknown_name_is_refused_with_those_there_are(dial):
    with pytest.raises(InputError, match=r"sloppy.*default, "):
        dial("sloppy")
