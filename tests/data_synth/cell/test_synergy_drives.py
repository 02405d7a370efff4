"""Drives of a hand with position servos, and its hand model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import (
    DESCRIPTION_SUFFIX,
    FingerDescription,
    HandDescription,
    hand_description,
)
from eyehand.data_synth.cell.hand_description import read_description
from eyehand.data_synth.cell.synergy_drives import HINGE_ARM_M, TAPER, SynergyDrives
from eyehand.data_synth.cell.synergy_hand_model import synergy_hand_model
from eyehand.errors import InputError
from eyehand.grasping.hands import HandCommand

FILE = Path(hand_description.__file__).parent / "assets" / "servo_hand.xml"
HAND = read_description(FILE.with_suffix(DESCRIPTION_SUFFIX))


def build_hand(description=HAND):
    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_path(str(FILE))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    drives = SynergyDrives(model, data, description)
    drives.pose(np.zeros(len(drives.drives)))
    mujoco.mj_forward(model, data)
    return model, data, drives


def run(model, data, drives, modes, values, seconds):
    drives.command(HandCommand(modes, np.array(values, dtype=float)))
    for _ in range(round(seconds / model.opt.timestep)):
        drives.apply()
        import_mujoco().mj_step(model, data)
    return drives.reading()


def test_placed_fingers_reach_excursion_against_gravity():
    model, data, drives = build_hand()
    half = drives.full / 2

    reading = run(model, data, drives, ("position",) * 3, half, 1.0)

    np.testing.assert_allclose(reading.excursions, half, atol=2e-4)
    np.testing.assert_allclose(reading.angles, [-0.075, 0.275] * 3, atol=0.03)
    assert reading.forces.max() == 0


def test_placing_keeps_motor_speed_limit():
    model, data, drives = build_hand()

    reading = run(model, data, drives, ("position",) * 3, drives.full, 0.1)

    assert (reading.excursions < 0.0035).all()
    assert (reading.excursions > 0.0015).all()


def test_pull_applies_joint_torques_of_tension():
    model, data, drives = build_hand()
    drives.pose(drives.full / 2)
    import_mujoco().mj_forward(model, data)
    drives.command(HandCommand(("pull", "position", "position"), np.array([20.0, 0.0, 0.0])))
    drives.apply()
    import_mujoco().mj_forward(model, data)

    torque = data.qfrc_actuator[:2] - data.qfrc_bias[:2]

    np.testing.assert_allclose(torque, 20.0 * HINGE_ARM_M * np.array([1.0, TAPER]), rtol=1e-6)


def test_tension_of_fingers_is_limited_by_thumb():
    _, _, drives = build_hand()
    drives.command(HandCommand(("pull", "pull", "hold"), np.array([1e3, 1e3, 1e3])))
    drives.apply()

    pulled = drives.reading().tensions

    assert pulled[:2].sum() < 4.0 / HINGE_ARM_M
    assert (pulled[:2] > 50.0).all()


def test_held_finger_yields_only_above_its_tension():
    model, data, drives = build_hand()
    run(model, data, drives, ("position",) * 3, drives.full / 2, 0.6)
    held = run(model, data, drives, ("hold",) * 3, [50.0] * 3, 0.1).angles
    tip = model.body("left_end").id
    data.xfrc_applied[tip, 0] = -3.0
    strong = run(model, data, drives, ("hold",) * 3, [50.0] * 3, 0.3).angles
    weak = run(model, data, drives, ("hold",) * 3, [5.0] * 3, 0.3).angles

    assert np.abs(strong - held).max() < 0.05
    assert np.abs(weak - held)[:2].max() > 0.2


def test_motor_on_coupled_tendon_is_supported():
    mujoco = import_mujoco()
    spec = mujoco.MjSpec.from_file(str(FILE))
    for name in ("left_knuckle", "left_bend"):
        spec.delete(next(motor for motor in spec.actuators if motor.name == name))
    tendon = spec.add_tendon(name="left")
    tendon.wrap_joint("left_knuckle", 1.0)
    tendon.wrap_joint("left_bend", 0.5)
    motor = spec.add_actuator(name="left", target="left", trntype=mujoco.mjtTrn.mjTRN_TENDON)
    motor.set_to_motor()
    model = spec.compile()
    data = mujoco.MjData(model)
    drives = SynergyDrives(model, data, HAND)
    mujoco.mj_forward(model, data)

    reading = run(model, data, drives, ("pull", "position", "position"), [10.0, 0.0, 0.0], 0.2)

    assert reading.excursions[0] > 0.003


@pytest.mark.parametrize(
    ("finger", "message"),
    [
        (FingerDescription("left", {"no_joint": (0.0, 1.0)}, ("left_tip",)), "joint 'no_joint'"),
        (FingerDescription("left", {"left_bend": (0.0, 1.0)}, ("no_geom",)), "geom 'no_geom'"),
    ],
)
def test_names_missing_in_file_raise(finger, message):
    with pytest.raises(InputError, match=message):
        build_hand(HandDescription((finger, HAND.fingers[-1])))


def test_finger_without_motor_raises():
    mujoco = import_mujoco()
    spec = mujoco.MjSpec.from_file(str(FILE))
    for motor in [motor for motor in spec.actuators if motor.name.startswith("left")]:
        spec.delete(motor)
    model = spec.compile()

    with pytest.raises(InputError, match="left: none of left_knuckle, left_bend has a motor"):
        SynergyDrives(model, mujoco.MjData(model), HAND)


def test_command_rejects_invalid_values():
    _, _, drives = build_hand()
    with pytest.raises(InputError, match="a mode and a value"):
        drives.command(HandCommand(("position",), np.zeros(1)))
    with pytest.raises(InputError, match="finite"):
        drives.command(HandCommand(("position",) * 3, np.array([np.nan, 0, 0])))


def test_hand_model_agrees_with_posed_hand():
    model, data, drives = build_hand()
    table = synergy_hand_model(model, HAND, "palm")
    drives.pose(table.excursions_at(0.05))
    import_mujoco().mj_kinematics(model, data)

    left, thumb = data.geom("left_tip"), data.geom("thumb_tip")
    ends = left.xpos[0] + abs(left.xmat[2]) * 0.016 + 0.0075
    lean = thumb.xmat.reshape(3, 3)
    start = thumb.xpos[0] - np.abs(lean[0]) @ [0.007, 0.013, 0.022]

    assert ends == pytest.approx(-0.025, abs=5e-4)
    assert start == pytest.approx(0.025, abs=5e-4)
    assert table.openings[0] < 0.002
    assert table.max_opening > 0.1
    assert (np.diff(table.excursions, axis=0) < 0).all()


def test_hand_that_cannot_close_raises_with_finger_ranges():
    model, _, _ = build_hand()
    open_thumb = FingerDescription("thumb", {"thumb_knuckle": (-0.9, -0.5)}, ("thumb_tip",))
    with pytest.raises(InputError, match=r"thumb [0-9]+ to [0-9]+ mm"):
        synergy_hand_model(model, replace(HAND, fingers=(*HAND.fingers[:-1], open_thumb)), "palm")
    with pytest.raises(InputError, match="no site or body 'plam'"):
        synergy_hand_model(model, HAND, "plam")
