"""Drives of the tendon hand: position, pull and hold commands, and pad forces."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell.tendon_drives import NO_LOAD_SPEED, TendonDrives
from eyehand.data_synth.cell.tendon_hand_model import HAND
from eyehand.errors import InputError
from eyehand.grasping.hands import HandCommand


@pytest.fixture
def hand():
    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_path(str(HAND))
    model.opt.gravity[:] = 0.0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    drives = TendonDrives(model, data)

    def run(modes, values, steps=300):
        drives.command(HandCommand(modes, np.array(values, dtype=float)))
        for _ in range(steps):
            drives.apply()
            mujoco.mj_step(model, data)
        return drives.reading()

    return model, data, drives, run


def test_hand_without_tension_opens(hand):
    _, _, _, run = hand

    assert run(("pull",) * 5, [0] * 5, 600).excursions == pytest.approx(np.zeros(5), abs=5e-4)


def test_finger_without_an_object_closes_no_faster_than_its_motor(hand):
    _, data, _, run = hand
    pulled = [0, 1]
    tensions = np.zeros(5)
    tensions[pulled] = 60.0
    fastest = 0.0
    for _ in range(60):
        run(("pull",) * 5, tensions, 1)
        fastest = max(fastest, float(-data.ten_velocity[pulled].min()))
    # One physics step adds up to 0.04 m/s.
    assert 0.5 * NO_LOAD_SPEED < fastest < 1.4 * NO_LOAD_SPEED


def test_held_drive_yields_only_above_its_limit(hand):
    _, data, _, run = hand
    thumb = 2
    modes = ["pull"] * 5
    run(tuple(modes), [0, 0, 12, 0, 0])
    modes[thumb] = "hold"
    held = run(tuple(modes), [0, 0, 100, 0, 0], 20).excursions[thumb]
    data.qfrc_applied[9] = -0.9
    loaded = run(tuple(modes), [0, 0, 100, 0, 0])

    assert loaded.excursions[thumb] == pytest.approx(held, abs=1e-4)
    assert loaded.tensions[thumb] > 60
    yielded = run(tuple(modes), [0, 0, 30, 0, 0])
    assert yielded.excursions[thumb] < held - 1e-3


def test_closed_hand_is_at_rest_and_fingertips_touch(hand):
    _, data, drives, run = hand
    reading = run(("pull",) * 5, [0, 40, 40, 0, 0], 500)

    assert np.abs(data.qvel).max() < 0.01
    assert reading.forces[drives.pads.index("middle_distal")] > 1.0
    assert reading.forces[drives.pads.index("thumb_distal")] > 1.0
    assert reading.forces[drives.pads.index("palm_pad")] == 0.0


def test_drives_support_name_prefix():
    mujoco = import_mujoco()
    spec = mujoco.MjSpec()
    spec.attach(mujoco.MjSpec.from_file(str(HAND)), frame=spec.worldbody.add_frame(), prefix="h/")
    model = spec.compile()
    drives = TendonDrives(model, mujoco.MjData(model), prefix="h/")

    assert drives.drives == ("outer", "middle", "thumb", "wrap", "thumb_wrap")
    assert drives.joints[0] == "index_1"
    assert drives.pads[-1] == "palm_pad"


def test_command_rejects_invalid_values(hand):
    _, _, drives, _ = hand

    with pytest.raises(InputError, match="mode"):
        drives.command(HandCommand(("pull",), np.zeros(1)))
    with pytest.raises(InputError, match="finite"):
        drives.command(HandCommand(("pull",) * 5, np.full(5, np.nan)))
