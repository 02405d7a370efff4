"""A hand's frame is a site or a body; a name that is not there brings those that are."""

from __future__ import annotations

import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import find_frame
from eyehand.data_synth.cell.name_suggestions import suggest_names
from eyehand.errors import InputError

MODEL = import_mujoco().MjModel.from_xml_string(
    '<mujoco><worldbody><body name="hand"><geom size="0.1"/><site name="palm"/></body>'
    "</worldbody></mujoco>"
)


def test_a_frame_is_a_site_or_a_body():
    assert find_frame(MODEL, "palm") == (1, 0)
    assert find_frame(MODEL, "hand") == (1, -1)


def test_a_wrong_name_brings_the_right_ones():
    with pytest.raises(InputError, match=r"'plam'.*there are palm, hand"):
        find_frame(MODEL, "plam")


def test_names_are_told_the_nearest_first_and_not_too_many():
    assert suggest_names("plam", ["tool", "palm", ""]) == "there are palm, tool"
    assert suggest_names("x", []) == "there are none with a name"
    assert suggest_names("x", [f"link {k}" for k in range(20)]).endswith("link 7, …")
