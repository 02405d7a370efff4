"""What the room offers can be had from it by name, at once or when it is asked for."""

from __future__ import annotations

import types

import pytest

import eyehand.grasping
from eyehand.grasping import Cell, ClearOptions, PickOptions, Robot, Tray, clear_table


@pytest.mark.parametrize("name", eyehand.grasping.__all__)
def test_each_name_is_there_and_is_no_module(name):
    offered = getattr(eyehand.grasping, name)
    assert not isinstance(offered, types.ModuleType)
    assert name in dir(eyehand.grasping)


def test_those_that_come_later_are_those_of_their_modules():
    assert Cell.__module__ == "eyehand.grasping.cell"
    assert ClearOptions.__module__ == clear_table.__module__ == "eyehand.grasping.clearing"
    assert PickOptions.__module__ == "eyehand.grasping.pick_options"
    assert Robot.__module__ == "eyehand.grasping.robot"
    assert Tray.__module__ == "eyehand.grasping.tray"


def test_a_name_that_is_not_offered_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Arm'"):
        eyehand.grasping.Arm  # noqa: B018 - reading the attribute is what is tested
