"""Public names of eyehand.grasping, imported at once or on first use."""

from __future__ import annotations

import types

import pytest

import eyehand.grasping
from eyehand.grasping import Cell, ClearOptions, PickOptions, Robot, Tray, clear_table

UNKNOWN = "Arms"


@pytest.mark.parametrize("name", eyehand.grasping.__all__)
def test_public_name_exists_and_is_not_module(name):
    exported = getattr(eyehand.grasping, name)
    assert not isinstance(exported, types.ModuleType)
    assert name in dir(eyehand.grasping)


def test_lazy_names_come_from_their_modules():
    assert Cell.__module__ == "eyehand.grasping.cell"
    assert ClearOptions.__module__ == clear_table.__module__ == "eyehand.grasping.clearing"
    assert PickOptions.__module__ == "eyehand.grasping.pick_options"
    assert Robot.__module__ == "eyehand.grasping.robot"
    assert Tray.__module__ == "eyehand.grasping.tray"


def test_unknown_name_raises_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Arms'"):
        getattr(eyehand.grasping, UNKNOWN)
