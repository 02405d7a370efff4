"""The clearance of the arm against the library coal and exact values."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.scenes import ReachingObstacle, make_reaching_scene
from eyehand.data_synth.scenes.arm_clearance import (
    HORIZON_M,
    ArmClearance,
    arm_spec,
    clearance_pairs,
)

mujoco = import_mujoco()
coal = import_module("coal")

SHALLOW_M = 0.03
"""Depth below the radius of every shell, m."""


def test_clearance_equals_minimum_of_coal_distances():
    rng = np.random.default_rng(0)
    for seed in range(6):
        scene = make_reaching_scene(seed)
        clearance = ArmClearance(scene.obstacles)
        model = arm_spec(scene.obstacles).compile()
        data = mujoco.MjData(model)
        pairs = clearance_pairs(model)
        for _ in range(40):
            q = rng.uniform(*clearance.joint_range)
            data.qpos[:] = q
            mujoco.mj_kinematics(model, data)
            expected = min(_coal_gap(model, data, one, other) for one, other in pairs)
            found = clearance.at(q)
            assert np.sign(found) == np.sign(expected)
            # MuJoCo's depth is not minimal where the axis of a shell passes through a box.
            if expected > -SHALLOW_M:
                assert found == pytest.approx(min(expected, HORIZON_M), abs=1e-7)


def test_pairs_are_moving_shells_with_boxes_and_unexcluded_shells():
    scene = make_reaching_scene(0, boxes=2)
    model = arm_spec(scene.obstacles).compile()
    names = {(model.geom(int(a)).name, model.geom(int(b)).name) for a, b in clearance_pairs(model)}
    shells = {model.geom(g).name for g in range(model.ngeom) if model.geom_contype[g]}
    moving = shells - {"base_shell", "box_1", "box_2"}
    assert len(moving) == 8
    own = {("base_shell", f"link{k}_{part}") for k, part in ((6, "shell"), (7, "shell"))}
    own |= {("base_shell", "link5_shell"), ("base_shell", "link5_neck")}
    assert names == own | {(shell, box) for shell in moving for box in ("box_1", "box_2")}


def test_clearance_of_upright_arm_to_wall_is_exact():
    wall = RigidTransform.from_components([0.5, 0.0, 0.7], Rotation.identity())
    clearance = ArmClearance([ReachingObstacle("wall", "box", (0.1, 1.0, 1.0), wall)])
    upright = np.zeros(7)
    assert clearance.at(upright) == pytest.approx(0.4 - 0.066, abs=1e-9)
    assert clearance.tool(upright) == pytest.approx([0.0, 0.0, 1.266])
    assert clearance.lowest_joint(upright) == pytest.approx(0.740)


def _coal_gap(model, data, one, other):
    solids = []
    for geom in (one, other):
        size = model.geom_size[geom]
        capsule = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE
        shape = coal.Capsule(size[0], 2 * size[1]) if capsule else coal.Box(*(2 * size))
        turn = data.geom_xmat[geom].reshape(3, 3)
        solids += [shape, coal.Transform3s(turn, data.geom_xpos[geom])]
    result = coal.DistanceResult()
    return coal.distance(*solids, coal.DistanceRequest(), result)
