"""The simulated arm with a pad: twists, delays, calibration, and joint limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.touch.arm_rig import CYCLE, ArmRig, RigOptions, home_pose
from eyehand.data_synth.pad import Arm, PlacedObject, pad_scene, pen
from eyehand.errors import InputError

NO_DELAY = RigOptions(lag=0.0, latency=0)


def test_pad_executes_twist_in_its_own_frame():
    rig = ArmRig(pad_scene(), options=NO_DELAY)
    before = rig.hand.pose
    twist = np.array([0.02, -0.01, 0.03, 0.0, 0.0, 0.2])
    for _ in range(25):
        rig.step(twist)
    moved = before.inv() * rig.hand.pose
    assert moved.rotation.as_rotvec() == pytest.approx([0.0, 0.0, 0.02], abs=1e-5)
    assert moved.translation == pytest.approx([0.002, -0.001, 0.003], abs=3e-5)
    assert rig.hand.twist == pytest.approx(twist, abs=1e-4)
    assert rig.hand.pose.translation == pytest.approx(rig.simulation.pad_pose().translation)


def test_arm_follows_with_latency_and_lag():
    rig = ArmRig(pad_scene(), options=RigOptions(lag=0.02, latency=2))
    speeds = []
    for _ in range(10):
        rig.step(np.array([0.01, 0, 0, 0, 0, 0]))
        speeds.append(rig.hand.twist[0])
    lagged = 0.01 * (1 - np.exp(-CYCLE * np.arange(1, 9) / 0.02))
    assert speeds[:2] == pytest.approx([0.0, 0.0])
    assert speeds[2:] == pytest.approx(lagged, rel=1e-2)


def test_calibrated_features_equal_true_force_and_position():
    place = np.add(home_pose().translation, [0.006, -0.004, 0.001])
    placed = PlacedObject(pen(), RigidTransform.from_translation(place))
    rig = ArmRig(pad_scene((placed,)), seed=3)
    sample = rig.step(np.zeros(6))[-1][0]
    assert rig.hand.features.force == pytest.approx(sample.force, rel=0.2)
    # The pad faces down, so its x-axis is the world's -x-axis.
    assert rig.hand.features.centre[:2] == pytest.approx([-0.006, -0.004], abs=2e-4)


def test_joint_limits_are_kept_and_reported():
    rig = ArmRig(pad_scene(), options=NO_DELAY)
    for _ in range(500):
        rig.step(np.array([0, 0, -0.5, 0, 0, 0]))
    robot = rig.hand.robot
    q = rig.simulation.joints
    assert ((q > robot.lower) & (q < robot.upper)).all()
    assert rig.hand.active_limits


def test_two_arms_move_independently():
    arms = (Arm(prefix="left_"), Arm(RigidTransform.from_translation([0.0, 1.0, 0.0]), "right_"))
    rig = ArmRig(pad_scene((), arms), arms, options=NO_DELAY)
    before = [hand.pose.translation for hand in rig.hands]
    rig.step(np.zeros(6), np.array([0, 0, 0.05, 0, 0, 0]))
    after = [hand.pose.translation for hand in rig.hands]
    assert after[0] == pytest.approx(before[0])
    assert after[1] - before[1] == pytest.approx([0, 0, -0.05 * CYCLE], abs=1e-7)
    assert after[1][1] - after[0][1] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("values", [{"lag": -1.0}, {"latency": -1}, {"lag": float("nan")}])
def test_rig_options_reject_invalid_values(values):
    with pytest.raises(InputError):
        RigOptions(**values)


def test_backlash_keeps_joints_within_free_play() -> None:
    rig = ArmRig(pad_scene(), options=replace(NO_DELAY, sensor="harsh"))
    measured, true = [], []
    for speed in (0.02, -0.02):
        for _ in range(15):
            rig.step(np.array([0.0, 0.0, speed, 0.0, 0.0, 0.0]))
            measured.append(rig.hand.pose.translation[2])
            true.append(rig.simulation.pad_pose().translation[2])
    gap = np.array(measured) - np.array(true)
    # 0.03° at each joint, at most 0.8 m from the pad.
    assert 2e-5 < np.ptp(gap) < 7 * np.radians(0.03) * 0.8
    # The joints stand still while the motors cross the free play after the turn.
    assert abs(true[16] - true[15]) < 0.5 * abs(measured[16] - measured[15])
