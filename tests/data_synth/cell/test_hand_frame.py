"""The frame of a hand: a site or a body, and suggestions for an unknown name."""

from __future__ import annotations

import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell.hand_frame import find_frame
from eyehand.data_synth.cell.name_suggestions import suggest_names
from eyehand.errors import InputError

MODEL = import_mujoco().MjModel.from_xml_string(
    '<mujoco><worldbody><body name="hand"><geom size="0.1"/><site name="palm"/></body>'
    "</worldbody></mujoco>"
)


def test_find_frame_accepts_site_or_body():
    assert find_frame(MODEL, "palm") == (1, 0)
    assert find_frame(MODEL, "hand") == (1, -1)


def test_unknown_frame_raises_with_known_names():
    with pytest.raises(InputError, match=r"'plam'.*there are palm, hand"):
        find_frame(MODEL, "plam")


def test_suggested_names_are_sorted_by_similarity_and_limited():
    assert suggest_names("plam", ["tool", "palm", ""]) == "there are palm, tool"
    assert suggest_names("x", []) == "there are none with a name"
    assert suggest_names("x", [f"link {k}" for k in range(20)]).endswith("link 7, …")
