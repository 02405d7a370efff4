"""Hand descriptions: reading, and errors for missing or invalid entries."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from eyehand.data_synth.cell import hand_description
from eyehand.data_synth.cell.hand_description import (
    FingerDescription,
    HandDescription,
    description_beside,
    read_description,
)
from eyehand.errors import InputError

ASSETS = Path(hand_description.__file__).parent / "assets"
THUMB = {"joints": {"t": [0.0, 1.0]}, "pads": ["tp"]}
FINGER = {"joints": {"f": [0.0, 1.0]}, "pads": ["fp"]}


def test_description_beside_hand_file_is_found():
    hand = description_beside(ASSETS / "servo_hand.xml")

    assert hand is not None
    assert [finger.name for finger in hand.fingers] == ["left", "right", "thumb"]
    assert hand.fingers[0].joints["left_knuckle"] == (-0.55, 0.40)
    assert hand.pad_names[-2:] == ("thumb_distal", "palm_pad")
    assert hand.joint_names[:3] == ("left_1", "left_2", "right_1")


def test_tendon_hand_has_no_description():
    assert description_beside(ASSETS / "hand.xml") is None


def test_thumb_is_sorted_last(tmp_path):
    path = tmp_path / "a.hand.json"
    path.write_text(json.dumps({"fingers": {"thumb": THUMB, "middle": FINGER}, "still": {"w": 1}}))

    hand = read_description(path)

    assert [finger.name for finger in hand.fingers] == ["middle", "thumb"]
    assert hand.still == {"w": 1.0}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], "object 'fingers' is missing"),
        ({"fingers": {"thumb": THUMB}}, "last a 'thumb'"),
        ({"fingers": {"middle": FINGER}}, "last a 'thumb'"),
        ({"fingers": {"middle": {"pads": ["p"]}, "thumb": THUMB}}, "middle has no object 'joints'"),
        (
            {"fingers": {"middle": {"joints": {"f": [0, 1]}}, "thumb": THUMB}},
            "one pad",
        ),
        ({"fingers": {"middle": FINGER | {"joints": {"f": 1}}, "thumb": THUMB}}, "two positions"),
        ({"fingers": {"middle": FINGER | {"joints": {"f": [1, 1]}}, "thumb": THUMB}}, "no joint"),
        ({"fingers": {"middle": FINGER, "thumb": FINGER}}, "used twice: f"),
        ({"fingers": {"middle": FINGER, "thumb": THUMB}, "wrist": {}}, "unknown keys wrist"),
        ({"fingers": {"middle": FINGER, "thumb": THUMB}, "prefix": 3}, "'prefix' must be"),
        ({"fingers": {"middle": FINGER, "thumb": THUMB}, "still": {"w": "x"}}, "still w"),
        ({"fingers": {"middle": FINGER, "thumb": THUMB}, "palm": "face"}, "palm must be a list"),
    ],
)
def test_invalid_description_raises_with_entry_and_file(tmp_path, content, message):
    path = tmp_path / "a.hand.json"
    path.write_text(json.dumps(content))

    with pytest.raises(InputError, match=message) as error:
        read_description(path)
    assert str(path) in str(error.value)


def test_file_without_json_raises(tmp_path):
    path = tmp_path / "a.hand.json"
    path.write_text("{")

    with pytest.raises(InputError, match="cannot read the hand's description"):
        read_description(path)


def test_descriptions_reject_non_finite_and_empty_values():
    with pytest.raises(InputError, match="finite"):
        FingerDescription("middle", {"f": (0.0, float("nan"))}, ("p",))
    with pytest.raises(InputError, match="none"):
        HandDescription(())


def test_prefix_is_added_to_names_of_description(tmp_path):
    content = {
        "prefix": "hand_",
        "fingers": {"middle": FINGER, "thumb": THUMB},
        "palm": ["face"],
        "still": {"wrist": 0.5},
    }
    path = tmp_path / "robot.hand.json"
    path.write_text(json.dumps(content))

    description = read_description(path)

    assert [finger.name for finger in description.fingers] == ["middle", "thumb"]
    assert list(description.fingers[0].joints) == [f"hand_{name}" for name in FINGER["joints"]]
    assert description.fingers[1].pads == tuple(f"hand_{name}" for name in THUMB["pads"])
    assert description.palm == ("hand_face",)
    assert description.still == {"hand_wrist": 0.5}
