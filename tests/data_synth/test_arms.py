"""The arms that come with eyehand have the geometry they are named for, and fit themselves."""

from __future__ import annotations

from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth import HOME_KEY, JOINT_SPEED, LBR_ARM, PLANAR_ARM, TOOL_SITE, import_mujoco

mujoco = import_mujoco()

LEAST_EXCLUDED_GAP_M = 0.05


def _loaded(path: Path):
    model = mujoco.MjModel.from_xml_path(str(path))
    return model, mujoco.MjData(model)


@pytest.fixture(scope="module")
def lbr():
    return _loaded(LBR_ARM)


def test_the_arm_has_the_published_links_limits_and_speeds(lbr):
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


def test_at_home_the_tool_points_down_in_front_of_the_arm(lbr):
    model, data = lbr
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME_KEY).id)
    mujoco.mj_forward(model, data)
    tool = data.site(TOOL_SITE)
    assert np.allclose(tool.xmat.reshape(3, 3)[:, 2], [0, 0, -1], atol=1e-7)
    assert np.allclose(tool.xpos, [0.5, 0, 0.25], atol=5e-3)
    assert data.body("link4").xpos[2] > data.body("link6").xpos[2] > tool.xpos[2]
    assert data.ncon == 0


def test_excluded_pairs_cannot_come_near_each_other_but_at_the_wrist_and_next_to_a_joint(lbr):
    model, data = lbr
    bodies = [(model.body(f"link{k}").id if k else model.body("base").id) for k in range(8)]
    excluded = {(int(sign) >> 16, int(sign) & 0xFFFF) for sign in model.exclude_signature}
    overlap = {*pairwise(bodies), (bodies[5], bodies[7])}
    apart = excluded - overlap
    assert len(apart) == 17
    shells = np.flatnonzero(model.geom_contype)
    geoms = [
        (int(a), int(b))
        for a, b in product(shells, shells)
        if (model.geom_bodyid[a], model.geom_bodyid[b]) in apart
    ]
    rng = np.random.default_rng(0)
    lower, upper = model.jnt_range.T
    for _ in range(400):
        # The hinges at their ends fold the arm most.
        posture = rng.uniform(lower, upper)
        folded = [1, 3, 5]
        posture[folded] = np.where(rng.random(3) < 0.5, lower[folded], upper[folded])
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        gaps = [mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a, b in geoms]
        assert min(gaps) > LEAST_EXCLUDED_GAP_M


def test_trim_has_no_weight_and_stands_out_of_the_shells_by_3_mm_at_most(lbr):
    model, _ = lbr
    trim = [g for g in range(model.ngeom) if not model.geom_contype[g]]
    assert trim
    assert not model.geom_conaffinity[trim].any()
    assert set(model.geom_group[trim]) == {1}
    bare = mujoco.MjSpec.from_file(str(LBR_ARM))
    for name in [model.geom(g).name for g in trim]:
        bare.delete(bare.geom(name))
    assert np.allclose(bare.compile().body_mass, model.body_mass)


def test_servos_follow_a_motion_within_their_torque_when_the_lag_is_made_up_for(lbr):
    model, data = lbr
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME_KEY).id)
    home = data.qpos.copy()
    lag = model.actuator_biasprm[:, 2] / model.actuator_biasprm[:, 1]
    swing, pace = 0.25, 2 * np.pi * 0.4
    worst = 0.0
    for _ in range(1500):
        ramp = 1 - np.exp(-data.time)
        angle = swing * ramp * np.sin(pace * data.time)
        rate = swing * (
            pace * ramp * np.cos(pace * data.time) + np.exp(-data.time) * np.sin(pace * data.time)
        )
        worst = max(worst, float(np.abs(data.qpos - home - angle).max()))
        data.ctrl[:] = home + angle + lag * rate
        mujoco.mj_step(model, data)
        assert (np.abs(data.qfrc_actuator) < model.jnt_actfrcrange[:, 1]).all()
    assert worst < 5e-3


def test_the_planar_arm_stays_in_its_plane_and_reaches_a_metre():
    model, data = _loaded(PLANAR_ARM)
    mujoco.mj_kinematics(model, data)
    assert np.allclose(data.site(TOOL_SITE).xpos, [1, 0, 0])
    mujoco.mj_resetDataKeyframe(model, data, model.key(HOME_KEY).id)
    mujoco.mj_forward(model, data)
    assert np.allclose(data.xaxis, [0, 0, 1])
    assert data.site(TOOL_SITE).xpos[2] == 0
    assert data.ncon == 0
    assert model.numeric(JOINT_SPEED).data.shape == (4,)
