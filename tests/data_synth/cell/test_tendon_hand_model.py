"""The table of openings of the tendon hand, against the simulated hand."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell.tendon_drives import TendonDrives
from eyehand.data_synth.cell.tendon_hand_model import HAND, tendon_hand_model
from eyehand.errors import InputError
from eyehand.grasping.hands import HandCommand


def test_hand_opens_from_zero_to_130_mm():
    hand = tendon_hand_model()

    assert hand.openings[0] == 0.0
    assert hand.max_opening >= 0.130
    assert hand.fingers == ("index", "middle", "ring", "thumb")
    assert hand.pads[-1] == "palm_pad"
    assert (hand.reaches > 0.08).all()
    assert (hand.outer_widths > hand.openings).all()


@pytest.mark.parametrize("opening", [0.005, 0.03, 0.08, 0.13])
def test_simulated_opening_equals_table(opening):
    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_path(str(HAND))
    data = mujoco.MjData(model)
    hand = tendon_hand_model()
    drives = TendonDrives(model, data)
    model.opt.gravity[:] = 0.0
    drives.command(HandCommand(("position",) * 5, hand.excursions_at(opening)))
    for _ in range(600):
        drives.apply()
        mujoco.mj_step(model, data)

    def half(name):
        return np.abs(data.geom(name).xmat.reshape(3, 3)[0]) @ model.geom(name).size

    inner = data.geom("middle_distal").xpos[0] + half("middle_distal")
    outer = data.geom("thumb_distal").xpos[0] - half("thumb_distal")
    assert outer - inner == pytest.approx(opening, abs=1.5e-3)
    assert np.abs(data.qvel).max() < 0.05


def test_hand_without_palm_site_raises():
    spec = import_mujoco().MjSpec.from_file(str(HAND))
    spec.site("palm").name = "other"

    with pytest.raises(InputError, match="palm"):
        tendon_hand_model(spec)


def test_hand_without_middle_finger_pinches_with_whole_row(tmp_path):
    path = tmp_path / "hand.xml"
    path.write_text(HAND.read_text().replace("middle_", "third_").replace('"middle"', '"third"'))

    hand, reference = tendon_hand_model(path), tendon_hand_model()

    assert hand.fingers == ("index", "third", "ring", "thumb")
    np.testing.assert_allclose(hand.openings, reference.openings)
    assert hand.thickness == pytest.approx(reference.thickness)
    assert hand.pinch_width > 2 * reference.pinch_width
