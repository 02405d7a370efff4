"""Fingertip pads: the image has the force and the centre of pressure of the contact."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell.fingertip_pads import (
    COLUMNS,
    LAYER_M,
    PITCH_M,
    ROWS,
    FingertipPads,
    tip_array,
)

FINGERTIP = """
<mujoco><option cone="elliptic" gravity="0 0 0"/><worldbody>
<body name="tip"><geom name="pad" type="box" size="0.006 0.008 0.0135"/>
<site name="face" pos="0.006 0 0"/></body>
<body name="ball" pos="{x} {y} {z}"><joint type="slide" axis="1 0 0"/>
<joint type="slide" axis="0 0 1"/>
<geom name="ball" size="0.01" mass="0.1"/></body>
</worldbody></mujoco>
"""


def press_fingertip(y: float, z: float, side: float = 1.0) -> tuple[np.ndarray, float]:
    """Return the forces of the tactels (rows, columns) and the contact force, N."""
    mujoco = import_mujoco()
    text = FINGERTIP.format(x=side * 0.0155, y=y, z=z)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    pads = FingertipPads(model, [model.geom("pad").id], [model.site("face").id])
    (image,) = pads.read(data)
    force = np.zeros(6)
    mujoco.mj_contactForce(model, data, 0, force)
    return (image.pressures * image.array.area).reshape(ROWS, COLUMNS), force[0]


@pytest.mark.parametrize(("y", "z"), [(0.0, 0.0), (0.003, -0.004), (-0.007, 0.012)])
def test_sum_of_tactel_forces_equals_contact_force(y: float, z: float):
    forces, contact = press_fingertip(y, z)
    assert contact > 0.1
    assert np.isclose(forces.sum(), contact)
    assert (forces >= 0).all()


def test_centre_of_pressure_equals_contact_position():
    forces, _ = press_fingertip(0.001, -0.002)
    rows = (np.arange(ROWS) - (ROWS - 1) / 2) * PITCH_M
    columns = (np.arange(COLUMNS) - (COLUMNS - 1) / 2) * PITCH_M
    along = (forces.sum(axis=1) @ rows) / forces.sum()
    across = (forces.sum(axis=0) @ columns) / forces.sum()
    # The rows run along the finger, its z-axis. The columns run along y.
    assert abs(along + 0.002) < 0.0005
    assert abs(across - 0.001) < 0.0007


def test_contact_on_back_gives_no_pressure():
    forces, contact = press_fingertip(0.0, 0.0, side=-1.0)
    assert contact > 0.1
    assert not forces.any()


def test_no_contact_gives_no_pressure():
    forces, _ = press_fingertip(0.1, 0.0)
    assert not forces.any()


def test_friction_moves_the_image_by_the_height_of_the_layer():
    mujoco = import_mujoco()
    model = mujoco.MjModel.from_xml_string(FINGERTIP.format(x=0.0155, y=0.0, z=0.0))
    data = mujoco.MjData(model)
    data.xfrc_applied[model.body("ball").id, 2] = 1.0
    mujoco.mj_step(model, data)
    pads = FingertipPads(model, [model.geom("pad").id], [model.site("face").id])
    normal, *friction = data.efc_force[:3]
    rows = (np.arange(ROWS) - (ROWS - 1) / 2) * PITCH_M
    still, sheared = (
        (pads.pressures(data, shear) * tip_array().area).reshape(ROWS, COLUMNS)
        for shear in (0.0, 1.0)
    )
    shift = (sheared - still).sum(axis=1) @ rows / normal
    assert np.isclose(sheared.sum(), normal)
    assert np.hypot(*friction) > 0.3
    # The ball is pulled along +z, and drags the face of the pad with it.
    assert np.isclose(shift, LAYER_M * np.hypot(*friction) / normal, rtol=1e-3)
