"""The included arms: published geometry, self-collision pairs, and servo tracking."""

from __future__ import annotations

from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth import LBR_ARM, PLANAR_ARM, TOOL_SITE, import_mujoco
from eyehand.data_synth.arms import HOME_KEY, JOINT_SPEED

mujoco = import_mujoco()

MIN_EXCLUDED_GAP_M = 0.05


def _load(path: Path):
    model = mujoco.MjModel.from_xml_path(str(path))
    return model, mujoco.MjData(model)


@pytest.fixture(scope="module")
def lbr():
    return _load(LBR_ARM)


def test_lbr_has_published_lengths_limits_and_speeds(lbr):
    model, data = lbr
    mujoco.mj_resetData(model, data)
    mujoco.mj_kinematics(model, data)
    heights = [data.body(f"link{k}").xpos[2] for k in (2, 4, 6)]
    heights.append(data.site(TOOL_SITE).xpos[2])
    assert heights == pytest.approx([0.340, 0.740, 1.140, 1.266], abs=1e-12)
    limits = [170, 120, 170, 120, 170, 120, 175]
    assert np.allclose(np.rad2deg(model.jnt_range), np.outer(limits, [-1, 1]), atol=1e-5)
    speeds = np.rad2deg(model.numeric(JOINT_SPEED).data)
    assert np.allclose(speeds, [98, 98, 100, 130, 140, 180, 180], atol=1e-5)
    axes = data.xaxis
    assert np.allclose(axes[[0, 2, 4, 6]], [0, 0, 1])
    assert np.allclose(axes[[1, 3, 5]], [[0, 1, 0], [0, -1, 0], [0, 1, 0]])


def test_tool_points_down_at_home(lbr):
    model, data = lbr
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME_KEY).id)
    mujoco.mj_forward(model, data)
    tool = data.site(TOOL_SITE)
    assert np.allclose(tool.xmat.reshape(3, 3)[:, 2], [0, 0, -1], atol=1e-7)
    assert np.allclose(tool.xpos, [0.5, 0, 0.25], atol=5e-3)
    assert data.body("link4").xpos[2] > data.body("link6").xpos[2] > tool.xpos[2]
    assert data.ncon == 0


def test_excluded_pairs_that_are_not_neighbours_keep_distance(lbr):
    model, data = lbr
    bodies = [(model.body(f"link{k}").id if k else model.body("base").id) for k in range(8)]
    excluded = {(int(sign) >> 16, int(sign) & 0xFFFF) for sign in model.exclude_signature}
    overlap = {*pairwise(bodies), (bodies[5], bodies[7])}
    not_adjacent = excluded - overlap
    assert len(not_adjacent) == 17
    shells = np.flatnonzero(model.geom_contype)
    geoms = [
        (int(a), int(b))
        for a, b in product(shells, shells)
        if (model.geom_bodyid[a], model.geom_bodyid[b]) in not_adjacent
    ]
    rng = np.random.default_rng(0)
    lower, upper = model.jnt_range.T
    for _ in range(400):
        # Joints at their limits fold the arm the most.
        posture = rng.uniform(lower, upper)
        folded = [1, 3, 5]
        posture[folded] = np.where(rng.random(3) < 0.5, lower[folded], upper[folded])
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        gaps = [mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a, b in geoms]
        assert min(gaps) > MIN_EXCLUDED_GAP_M


def test_trim_geoms_do_not_collide_and_have_no_mass(lbr):
    model, _ = lbr
    trim = [g for g in range(model.ngeom) if not model.geom_contype[g]]
    assert trim
    assert not model.geom_conaffinity[trim].any()
    assert set(model.geom_group[trim]) == {1}
    bare = mujoco.MjSpec.from_file(str(LBR_ARM))
    for name in [model.geom(g).name for g in trim]:
        bare.delete(bare.geom(name))
    assert np.allclose(bare.compile().body_mass, model.body_mass)


def test_servos_track_motion_within_torque_limits_with_lag_compensation(lbr):
    model, data = lbr
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME_KEY).id)
    home = data.qpos.copy()
    lag = model.actuator_biasprm[:, 2] / model.actuator_biasprm[:, 1]
    amplitude, angular_frequency = 0.25, 2 * np.pi * 0.4
    max_error = 0.0
    for _ in range(1500):
        ramp = 1 - np.exp(-data.time)
        angle = amplitude * ramp * np.sin(angular_frequency * data.time)
        rate = amplitude * (
            angular_frequency * ramp * np.cos(angular_frequency * data.time)
            + np.exp(-data.time) * np.sin(angular_frequency * data.time)
        )
        max_error = max(max_error, float(np.abs(data.qpos - home - angle).max()))
        data.ctrl[:] = home + angle + lag * rate
        mujoco.mj_step(model, data)
        assert (np.abs(data.qfrc_actuator) < model.jnt_actfrcrange[:, 1]).all()
    assert max_error < 5e-3


def test_planar_arm_is_planar_and_reaches_one_metre():
    model, data = _load(PLANAR_ARM)
    mujoco.mj_kinematics(model, data)
    assert np.allclose(data.site(TOOL_SITE).xpos, [1, 0, 0])
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME_KEY).id)
    mujoco.mj_forward(model, data)
    assert np.allclose(data.xaxis, [0, 0, 1])
    assert data.site(TOOL_SITE).xpos[2] == 0
    assert data.ncon == 0
    assert model.numeric(JOINT_SPEED).data.shape == (4,)
