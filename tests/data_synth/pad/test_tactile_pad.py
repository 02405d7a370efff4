"""The simulated pad: balance of forces and torques, exact cases, and a ray-cast reference."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import Foam, PadOptions, TactilePad
from eyehand.data_synth.pad.tactel_spread import spread_weights
from eyehand.errors import InputError

mujoco = import_mujoco()
FOAM = Foam()
SHAPES = {
    "plate": '<geom name="g" type="box" size=".02 .03 .01" pos=".003 .001 .009"/>',
    "turned box": '<geom type="box" size=".02 .012 .01" pos=".003 -.004 .0092" euler="3 2 35"/>',
    "box edge": '<geom type="box" size=".02 .02 .02" pos="0 0 .0275" xyaxes="3 2 0 -2 3 3.6"/>',
    "sphere": '<geom type="sphere" size=".03" pos=".003 .001 .0285"/>',
    "ellipsoid": '<geom type="ellipsoid" size=".03 .02 .02" euler="20 30 40" pos=".003 0 .0195"/>',
    "probe": '<geom type="cylinder" size=".001 .02" pos=".003 .001 .0185"/>',
    "tilted cylinder": '<geom type="cylinder" size=".02 .02" pos="0 0 .0205" euler="0 4 30"/>',
    "rod": '<geom type="capsule" size=".005 .02" pos=".01 0 .0038" euler="0 88 25"/>',
    "chain": "".join(
        f'<geom type="capsule" size=".003" fromto="{a} {b} .002 {a + 0.01} {-b} .002"/>'
        for a, b in ((-0.015, 0.003), (-0.005, -0.003), (0.005, 0.003))
    ),
}


def build(geoms: str, **options: Any) -> tuple[Any, Any, TactilePad]:
    """Return the model, the data and a pad at the world's origin under an object."""
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="pad"><site name="pad"/></body>'
        f'<body name="object">{geoms}</body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data, TactilePad(model, data, options=PadOptions(**options))


def reference(model: Any, data: Any, points: int = 800) -> tuple[float, np.ndarray]:
    """Return force and torque about the pad's origin, from MuJoCo rays on a dense regular grid."""
    half, start = 0.04, 0.1
    ticks = (np.arange(points) + 0.5) / points * 2 * half - half
    hit = np.zeros(1, np.int32)
    force, torque = 0.0, np.zeros(3)
    for x in ticks:
        if abs(x) > 0.036:
            continue
        for y in ticks[np.abs(ticks) < 0.032]:
            distance = mujoco.mj_ray(model, data, [x, y, -start], [0, 0, 1.0], None, 1, -1, hit)
            if 0 <= distance < start:
                pressure = float(FOAM.pressure(np.array(start - distance)))
                force += pressure
                torque += np.array([y, -x, 0.0]) * pressure
    cell = (2 * half / points) ** 2
    return force * cell, torque * cell


@pytest.mark.parametrize("shape", SHAPES)
def test_image_sums_to_force_and_reaction(shape: str) -> None:
    model, data, pad = build(SHAPES[shape])
    assert pad.contact() >= 1
    assert pad.force > 0.01
    assert pad.true_pressures.sum() * pad.array.area / pad.force == pytest.approx(1.0, abs=1e-12)
    # By action and reaction, the net force and the net torque about the origin are zero.
    applied = data.xfrc_applied
    assert applied[:, :3].sum(axis=0) == pytest.approx(0.0, abs=1e-12)
    arms = np.cross(data.xipos, applied[:, :3])
    assert (applied[:, 3:] + arms).sum(axis=0) == pytest.approx(0.0, abs=1e-12)
    assert applied[model.body("object").id, 2] == pytest.approx(pad.force)


@pytest.mark.parametrize("shape", [s for s in SHAPES if s != "tilted cylinder"])
def test_image_has_torque_of_force(shape: str) -> None:
    _, _, pad = build(SHAPES[shape])
    pad.contact()
    forces = pad.true_pressures * pad.array.area
    x, y = pad.array.positions[:, 0], pad.array.positions[:, 1]
    # A blur of half the pitch leaves an error of 0.02 mm from the tactel grid.
    assert forces @ y == pytest.approx(pad.wrench[3], abs=2e-5 * pad.force)
    assert -forces @ x == pytest.approx(pad.wrench[4], abs=2e-5 * pad.force)
    assert pad.centre[:2] == pytest.approx(
        np.array([-pad.wrench[4], pad.wrench[3]]) / pad.force, abs=1e-9
    )


@pytest.mark.parametrize("shape", SHAPES)
def test_kernel_equals_dense_rays(shape: str) -> None:
    model, data, pad = build(SHAPES[shape])
    pad.contact()
    force, torque = reference(model, data, 400)
    # The regular grid resolves areas to a cell of 0.2 mm.
    margin = {"probe": 0.1, "plate": 0.02, "turned box": 0.02}.get(shape, 0.015)
    assert pad.force == pytest.approx(force, rel=margin)
    assert pad.wrench[3:5] / pad.force == pytest.approx(torque[:2] / force, abs=1e-4)


def test_plate_larger_than_pad_gives_uniform_pressure() -> None:
    _, _, pad = build('<geom type="box" size=".06 .06 .01" pos="0 0 .009" euler="0 0 0"/>')
    pad.contact()
    assert pad.true_pressures == pytest.approx(float(FOAM.pressure(np.array(1e-3))), rel=1e-3)


@pytest.mark.parametrize("depth", [2e-4, 1e-3, 2e-3])
def test_force_of_sphere_equals_integral_over_columns(depth: float) -> None:
    radius = 0.03
    _, _, pad = build(f'<geom type="sphere" size="{radius}" pos="0 0 {radius - depth}"/>')
    pad.contact()

    def ring(r: float) -> float:
        sunken = depth - radius + np.sqrt(radius**2 - r**2)
        return 2 * np.pi * r * float(FOAM.pressure(np.array(sunken)))

    exact = quad(ring, 0.0, np.sqrt(2 * radius * depth - depth**2))[0]
    assert pad.force == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("x", np.linspace(0.0, 0.005, 6))
def test_probe_between_tactels_has_exact_centre(x: float) -> None:
    _, _, pad = build(f'<geom type="cylinder" size=".001 .02" pos="{x} .0025 .018"/>')
    pad.contact()
    assert pad.force == pytest.approx(np.pi * 1e-6 * FOAM.pressure(np.array(2e-3)), rel=5e-3)
    assert pad.centre[:2] == pytest.approx([x, 0.0025], abs=1e-6)
    centre = pad.true_pressures @ pad.array.positions / pad.true_pressures.sum()
    assert centre[:2] == pytest.approx([x, 0.0025], abs=2e-5)


def test_soft_object_gives_less_force_than_rigid_one() -> None:
    model, data, rigid = build(SHAPES["plate"])
    rigid.contact()
    soft = Foam(0.02, 20e3)
    pad = TactilePad(model, data, softness={"g": soft})
    pad.contact()
    area = 0.04 * 0.06
    shared = FOAM.compression(np.array(pad.force / area)) + soft.compression(
        np.array(pad.force / area)
    )
    assert shared == pytest.approx(1e-3, rel=1e-3)
    assert pad.force < 0.3 * rigid.force


def test_overlapping_solids_are_counted_once() -> None:
    once = '<geom type="box" size=".02 .02 .01" pos="0 0 .009"/>'
    half = '<geom type="box" size=".015 .02 .01" pos="{} 0 .009"/>'
    _, _, pad = build(once)
    pad.contact()
    _, _, split = build(half.format(0.005) + half.format(-0.005))
    split.contact()
    assert split.force == pytest.approx(pad.force, rel=0.03)
    _, _, twice = build(once + once)
    twice.contact()
    assert twice.force == pytest.approx(pad.force, rel=1e-9)


def test_sinking_raises_pressure_and_sliding_adds_friction() -> None:
    model, data, pad = build(SHAPES["plate"])
    pad.contact()
    static_force = pad.force
    data.time += 1e-3
    data.geom_xpos[model.geom("g").id] += [2e-3, 0.0, -1e-5]
    pad.contact()
    assert pad.force > static_force * 1.01
    assert pad.wrench[0] == pytest.approx(-0.6 * pad.force, rel=1e-3)
    assert pad.true_shear[:, 0].sum() * pad.array.area == pytest.approx(-pad.wrench[0])
    assert abs(pad.wrench[1]) < 1e-9
    # A second call at the same time has no velocity.
    pad.contact()
    assert np.abs(pad.true_shear).max() == 0.0


def test_rotating_object_applies_torque() -> None:
    model, data, pad = build('<geom name="g" type="cylinder" size=".01 .01" pos="0 0 .009"/>')
    pad.contact()
    data.time += 1e-3
    rotation = Rotation.from_rotvec([0, 0, 0.05]).as_matrix()
    data.geom_xmat[model.geom("g").id] = rotation.ravel()
    pad.contact()
    # The torque of full friction on a disc is 2/3 mu F r.
    assert pad.wrench[5] == pytest.approx(-2 / 3 * 0.6 * pad.force * 0.01, rel=0.01)


@pytest.mark.parametrize("lift", [0.0285, 0.0295])
def test_mesh_contact_equals_rays(lift: float) -> None:
    vertices = np.random.default_rng(0).standard_normal((800, 3))
    vertices *= [0.05, 0.04, 0.03] / np.linalg.norm(vertices, axis=1, keepdims=True)
    text = " ".join(f"{value:.6f}" for value in vertices.ravel())
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><asset><mesh name="egg" vertex="{text}"/></asset><worldbody><body name="pad">'
        '<site name="pad"/></body><body><geom type="mesh" mesh="egg" euler="5 3 20" '
        f'pos=".004 -.003 {lift}"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pad = TactilePad(model, data)
    assert pad.contact() == 1
    force, torque = reference(model, data, 160)
    assert pad.force == pytest.approx(force, rel=0.01)
    assert pad.wrench[3:5] / pad.force == pytest.approx(torque[:2] / force, abs=1e-4)
    assert pad.true_pressures.sum() * pad.array.area == pytest.approx(pad.force, rel=1e-12)
    assert data.xfrc_applied[2, 2] == pytest.approx(pad.force)
    # A mesh that moves away leaves no contact.
    data.geom_xpos[0, 2] += 0.1
    assert pad.contact() == 0
    assert pad.force == 0.0
    assert np.abs(data.xfrc_applied).max() == 0.0


@pytest.mark.parametrize("shape", ["chain", "turned box", "rod", "sphere", "box edge"])
@pytest.mark.parametrize("border", [False, True])
def test_force_and_torque_are_smooth_in_motion(shape: str, border: bool) -> None:
    _, data, pad = build(SHAPES[shape])
    start = data.geom_xpos.copy()
    pad.contact()
    full_force = pad.force
    wrenches = []
    # Steps of 20 µm: inside the pad with 0.1 mm of extra depth, or outwards across its border.
    for k in range(50):
        along = np.array([0.02, 0.002, -0.002]) if not border else np.array([0.02, 0.01, 0.0])
        data.geom_xpos[:] = start + 1e-3 * k * along + (0.035 * border, 0.0, 0.0)
        pad.contact()
        wrenches.append([pad.force, *(pad.wrench[3:5] / 0.04)])
    jumps = np.abs(np.diff(wrenches, n=2, axis=0)).max()
    assert jumps < 1e-3 * full_force


def test_object_behind_pad_has_no_contact() -> None:
    _, _, pad = build('<geom type="sphere" size=".01" pos="0 0 -.03"/>')
    assert pad.contact() == 0
    assert pad.force == 0.0
    assert np.isnan(pad.centre).all()


def test_spread_weights_keep_force_and_uniformity() -> None:
    weights = spread_weights(16, 0.005, 0.0025)
    assert weights.sum(axis=0) == pytest.approx(1.0, abs=1e-12)
    assert weights.sum(axis=1) == pytest.approx(2.0, abs=1e-6)
    with pytest.raises(InputError, match="spread"):
        spread_weights(16, 0.005, 0.001)


def test_pad_rejects_unknown_names() -> None:
    model, data, _ = build(SHAPES["plate"])
    with pytest.raises(InputError, match="no site"):
        TactilePad(model, data, site="finger")
    with pytest.raises(InputError, match="no geom"):
        TactilePad(model, data, softness={"ball": Foam()})
