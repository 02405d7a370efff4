"""Naming rules of hand models, and error messages for names that break them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.grasping import HandModel
from eyehand.grasping.hands import HandReading, nominal_hand
from eyehand.grasping.hands.closing import Closing, open_command, preshape_command
from eyehand.grasping.hands.hand_names import WRAP_DRIVES
from eyehand.grasping.hands.hand_state import is_holding


def hand(drives=("jaw", "thumb"), fingers=("jaw", "thumb"), pads=None, joints=()) -> HandModel:
    pads = tuple(f"{name}_distal" for name in fingers) if pads is None else pads
    openings = np.linspace(0.0, 0.08, 5)
    return HandModel(
        drives=drives,
        joints=joints,
        pads=pads,
        fingers=fingers,
        openings=openings,
        reaches=np.full(5, 0.05),
        excursions=np.tile((0.04 - openings / 2)[:, None], len(drives)),
        outer_widths=openings + 0.04,
        row_width=0.02,
        pinch_width=0.02,
        thickness=0.01,
        palm_depth=0.1,
    )


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ({"drives": ("jaw",)}, r"one drive must be 'thumb'; got 'jaw'; valid are 'jaw', 'thumb'"),
        ({"drives": ("thumb",)}, r"no drive moves 'jaw'; got 'thumb'; valid"),
        ({"drives": ("jaw", "thumb", "lid")}, r"drive 'lid' moves nothing"),
        (
            {"drives": ("jaw", "thumb", "jaw")},
            r"drives .* unique, non-empty names, but 'jaw' is not",
        ),
        ({"drives": ("jaw", "thumb", "")}, r"drives .* unique, non-empty names, but '' is not"),
        ({"fingers": ("left", "right")}, r"then 'thumb'; got 'left', 'right'"),
        ({"fingers": ("thumb", "jaw")}, r"then 'thumb'; got 'thumb', 'jaw'"),
        ({"fingers": ("thumb",)}, r"must be one or more fingers, then 'thumb'"),
        (
            {"fingers": ("jaw", "jaw2", "thumb")},
            r"'jaw2' must have another name: .* begin with 'jaw'",
        ),
        (
            {"fingers": ("palmar", "thumb")},
            r"'palmar' must have another name: .* begin with 'palm'",
        ),
        ({"fingers": ("wrap", "thumb")}, r"'wrap' must have another name: .* are drives"),
        ({"pads": ("jaw_tip", "thumb_tip")}, r"'jaw_distal', 'thumb_distal' is missing, got"),
        ({"pads": ("jaw_distal", "thumb_distal", "cover")}, r"pad 'cover' has no finger"),
        ({"joints": ("jaw_1", "jaw_1")}, r"joints .* unique, non-empty names"),
        ({"joints": ("jaw_1", "elbow")}, r"joint 'elbow' has no finger: .* 'jaw', 'thumb'"),
        ({"joints": ("palm_1",)}, r"joint 'palm_1' has no finger"),
    ],
)
def test_invalid_name_is_reported_with_valid_ones(names, message):
    with pytest.raises(InputError, match=message) as error:
        hand(**names)
    assert "\n" not in str(error.value)


NAMES = st.sampled_from(["middle", "index", "jaw", "jaw2", "wrapper"])


@st.composite
def hands(draw) -> HandModel:
    """Draw valid hands: each finger has a drive with its name, or shares one."""
    fingers = draw(st.lists(NAMES, min_size=1, max_size=3, unique=True))
    assume(not {"jaw", "jaw2"} <= set(fingers))
    own = [name for name in fingers if draw(st.booleans())]
    shared = [] if len(own) == len(fingers) else ["several"]
    wraps = draw(st.lists(st.sampled_from(WRAP_DRIVES), unique=True))
    drives = draw(st.permutations([*own, *shared, *wraps, "thumb"]))
    inner = draw(st.lists(st.sampled_from([*fingers, "thumb", "palm"]), unique=True))
    fingers = (*fingers, "thumb")
    pads = (*(f"{name}_distal" for name in fingers), *(f"{name}_inner" for name in inner))
    return hand(tuple(drives), fingers, pads)


@given(hands(), st.sampled_from(["pincer", "precision", "power"]))
def test_valid_hand_closes_holds_and_opens(model, prototype):
    closing = Closing(model, prototype, 0.06)
    pulled = model.excursions_at(0.06)
    for touch in (0.0, 0.0, 1.0, 1.0, 1.0):
        forces = np.full(len(model.pads), touch)
        reading = HandReading(pulled, np.zeros(len(model.drives)), np.zeros(0), forces, ())
        command = closing.step(reading, 0.004)
        assert np.isfinite(command.values).all()
    assert closing.touched
    assert is_holding(reading, model)
    assert len(open_command(model).modes) == len(preshape_command(model, 0.05, prototype).modes)


def test_hand_without_middle_finger_pinches_with_all_fingers():
    model = hand(("left", "right", "thumb"), ("left", "right", "thumb"))
    np.testing.assert_allclose(
        preshape_command(model, 0.03, "pincer").values, model.excursions_at(0.03)
    )
    closing = Closing(model, "pincer", 0.03)
    command = preshape_command(model, 0.03, "pincer")
    pulled = model.excursions_at(0.02)
    for _ in range(200):
        reading = HandReading(pulled, np.zeros(3), np.zeros(0), np.full(3, 2.0), ())
        command = closing.step(reading, 0.004)
    assert closing.state == "holding"
    assert command.modes == ("pull", "pull", "hold")
    assert command.values[2] > command.values[:2].sum()


def test_nominal_hand_is_valid():
    assert nominal_hand().fingers[-1] == "thumb"
