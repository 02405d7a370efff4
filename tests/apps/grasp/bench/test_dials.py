"""Named settings of perception and control."""

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


def test_default_dials_equal_default_options():
    default = perception_dial(DEFAULT)
    assert replace(default, segmentation=SegmentationOptions()) == PerceiveOptions()
    assert default.segmentation.min_object < SegmentationOptions().min_object
    assert control_dial(DEFAULT) == PickOptions()


def test_dials_differ():
    assert len({repr(perception_dial(name)) for name in PERCEPTION}) == len(PERCEPTION)
    assert len({repr(control_dial(name)) for name in CONTROL}) == len(CONTROL)


def test_perception_dials_order_effort():
    fast, default, fine = (perception_dial(name) for name in ("fast", DEFAULT, "fine"))
    assert fast.segmentation.stride > default.segmentation.stride
    assert fast.fit.points < default.fit.points < fine.fit.points
    assert fast.fit.starts < default.fit.starts < fine.fit.starts


def test_control_dials_order_speed_and_time_limit():
    slow, default, fast = (control_dial(name) for name in ("slow", DEFAULT, "fast"))
    assert slow.speed < default.speed < fast.speed
    assert slow.time_limit(3.0) > default.time_limit(3.0) == fast.time_limit(3.0)


def test_planner_dial_changes_only_rollouts():
    base = PickOptions(pre_grasp_distance=0.05)
    changed = control_dial("planner", base)
    assert changed.planner.rollouts > base.planner.rollouts
    assert changed.pre_grasp_distance == base.pre_grasp_distance


def test_fixed_grip_dial_changes_only_the_grip():
    changed = control_dial("fixed-grip")
    assert PickOptions().follow_load
    assert changed == replace(PickOptions(), follow_load=False)


@pytest.mark.parametrize("dial", [perception_dial, control_dial])
def test_unknown_dial_is_refused_with_valid_names(dial):
    with pytest.raises(InputError, match=r"sloppy.*default, "):
        dial("sloppy")
