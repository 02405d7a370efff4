"""The simulation of pads: image rates, driven arms, light free objects, and scenes."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import (
    Arm,
    PadSimulation,
    Part,
    PlacedObject,
    TactilePad,
    TouchObject,
    box_edge,
    cable,
    pad_scene,
    padded_arm,
    pen,
    probe,
    soft_ball,
    tilted_face,
    toy_box,
    unknown_object,
)
from eyehand.errors import InputError

mujoco = import_mujoco()
GRAVITY = 9.81
LINE = np.column_stack([np.linspace(-0.05, 0.05, 15), np.zeros(15), np.full(15, -0.003)])


def lying_pad(geom: str, pose: str = 'pos="0 0 .003"', rate: float = 1900.0) -> PadSimulation:
    """Return a simulation of a free body above a pad that points up."""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{1 / 1900}" integrator="implicitfast"/><worldbody>'
        '<body name="pad"><site name="pad"/></body>'
        f'<body name="free" {pose}><freejoint/>{geom}</body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return PadSimulation(model, data, [TactilePad(model, data)], image_rate=rate)


@pytest.mark.parametrize("half", [0.01, 0.02, 0.035])
@pytest.mark.parametrize("pose", ['pos="0 0 .003"', 'pos=".002 .001 .008" euler="6 4 20"'])
def test_light_plate_comes_to_rest(half: float, pose: str) -> None:
    simulation = lying_pad(f'<geom type="box" size="{half} {half} .002" mass=".02"/>', pose)
    simulation.advance(duration=0.6)
    forces = np.array([m[0].force for m in simulation.advance(duration=0.2)])
    assert forces.mean() == pytest.approx(0.02 * GRAVITY, rel=1e-3)
    assert forces.std() < 1e-3 * forces.mean()


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder", "ellipsoid"])
def test_light_round_body_comes_to_rest(kind: str) -> None:
    size = ".02 .01 .01" if kind == "ellipsoid" else ".01 .02"
    turn = "0 0 0" if kind == "ellipsoid" else "0 90 0"
    geom = f'<geom type="{kind}" size="{size}" euler="{turn}" mass=".02"/>'
    simulation = lying_pad(geom, 'pos="0 0 .012"')
    simulation.advance(duration=1.0)
    forces = np.array([m[0].force for m in simulation.advance(duration=0.2)])
    assert forces.mean() == pytest.approx(0.02 * GRAVITY, rel=0.01)
    assert forces.std() < 0.01 * forces.mean()


def test_impact_of_light_plate_is_stable() -> None:
    simulation = lying_pad('<geom type="box" size=".02 .02 .002" mass=".02"/>', 'pos="0 0 .004"')
    simulation.data.qvel[2] = -0.3
    speeds = []
    for _ in range(100):
        simulation.advance()
        speeds.append(np.abs(simulation.data.qvel[:3]).max())
    assert max(speeds) < 0.36
    assert speeds[-1] < 0.25


def test_friction_stops_sliding_plate() -> None:
    simulation = lying_pad('<geom type="box" size=".01 .01 .002" mass=".02"/>', 'pos="0 0 .0019"')
    simulation.advance(duration=0.3)
    simulation.data.qvel[0] = 0.1
    simulation.advance(duration=0.01)
    assert simulation.data.qvel[0] == pytest.approx(0.1 - 0.6 * GRAVITY * 0.01, abs=5e-3)
    simulation.advance(duration=0.2)
    assert abs(simulation.data.qvel[0]) < 1e-4


@pytest.mark.parametrize(("rate", "images"), [(1900.0, 1900), (250.0, 250)])
def test_images_have_requested_rate(rate: float, images: int) -> None:
    simulation = lying_pad('<geom type="sphere" size=".01"/>', 'pos="0 0 .5"', rate)
    images_seen = [moments for _ in range(250) for moments in simulation.advance()]
    assert len(images_seen) == images
    assert np.diff([m[0].time for m in images_seen]) == pytest.approx(1 / rate, abs=1e-9)
    assert simulation.time == pytest.approx(1.0)


@pytest.mark.parametrize(
    "item",
    [
        pen(),
        toy_box(),
        soft_ball(),
        probe(),
        box_edge(),
        tilted_face(0.05),
        cable(LINE, 0.003),
        unknown_object(),
    ],
    ids=lambda item: item.name,
)
def test_arm_presses_each_object_at_its_position(item: TouchObject) -> None:
    top = PadSimulation.of_scene(pad_scene()).pad_pose().translation
    gap = 0.0025 if item.name in ("unknown", "tilted_face") else 0.001
    at = RigidTransform.from_translation(np.add(top, [0.005, -0.004, -gap]))
    simulation = PadSimulation.of_scene(pad_scene((PlacedObject(item, at),)), image_rate=250)
    assert simulation.advance()[-1][0].force == 0.0
    before = simulation.pad_pose().translation
    simulation.advance(down(simulation, 0.03), 0.1)
    assert simulation.pad_pose().translation - before == pytest.approx([0, 0, -0.003], abs=2e-5)
    moment = simulation.advance()[-1][0]
    assert moment.force > 0.005
    pad = simulation.pads[0]
    assert pad.true_pressures.sum() * pad.array.area == pytest.approx(moment.force, rel=1e-9)
    if item.name in ("pen", "probe", "soft_ball", "toy_box"):
        # The pad points down: its x-axis is the world's -x.
        assert moment.centre[:2] == pytest.approx([-0.005, -0.004], abs=2e-4)


def test_two_arms_with_pads_share_cell() -> None:
    arms = (
        Arm(RigidTransform.from_translation([0.0, 0.0, 0.0]), "left_"),
        Arm(RigidTransform.from_translation([0.0, 1.0, 0.0]), "right_"),
    )
    scene = pad_scene((), arms)
    simulation = PadSimulation.of_scene(scene)
    assert scene.sites == ("left_pad", "right_pad")
    assert len(simulation.joints) == 14
    left, right = (simulation.pad_pose(k).translation for k in (0, 1))
    assert right - left == pytest.approx([0.0, 1.0, 0.0])
    assert len(simulation.advance(np.zeros(14))[0]) == 2


def test_driven_arm_pushes_free_object() -> None:
    top = PadSimulation.of_scene(pad_scene()).pad_pose().translation
    block = TouchObject("block", (Part("box", (0.02, 0.02, 0.02), (0.0, 0.0, -0.02)),))
    table = TouchObject("table", (Part("box", (0.1, 0.1, 0.01), (0.0, 0.0, -0.05)),))
    at = RigidTransform.from_translation(top - [0.0, 0.0, 0.001])
    scene = pad_scene((PlacedObject(block, at, "free", 0.02), PlacedObject(table, at)))
    simulation = PadSimulation.of_scene(scene)
    simulation.advance(down(simulation, 0.02), 0.1)
    moments = simulation.advance(duration=0.1)
    forces = np.array([m[0].force for m in moments])
    assert forces[-1] > 0.5
    assert forces[-100:].std() < 0.01 * forces[-1]
    # The block follows a sideways push.
    simulation.advance(aside(simulation, 0.02), 0.5)
    moved = simulation.data.body("block").xpos - at.translation
    assert abs(moved[0]) < 0.02


def test_mocap_object_moves_during_simulation() -> None:
    top = PadSimulation.of_scene(pad_scene()).pad_pose().translation
    at = RigidTransform.from_translation(np.add(top, [0.0, 0.0, 0.0015]))
    scene = pad_scene((PlacedObject(probe(), at, "mocap"),))
    simulation = PadSimulation.of_scene(scene)

    def move(time: float) -> None:
        simulation.data.mocap_pos[0] = np.add(at.translation, [0.02 * time, 0, 0])

    moments = simulation.advance(duration=0.1, on_step=move)
    positions = np.array([m[0].centre[0] for m in moments])
    assert np.diff(positions) == pytest.approx(-0.02 / 1900, abs=2e-7)
    assert np.abs(simulation.pads[0].true_shear).max() > 1.0


def test_simulation_is_repeatable_with_seed() -> None:
    def run(seed: int) -> Any:
        simulation = PadSimulation.of_scene(pad_scene(), seed=seed)
        return np.array([m[0].raw for m in simulation.advance(duration=0.02)])

    assert (run(1) == run(1)).all()
    assert (run(1) != run(2)).any()


def test_simulation_rejects_invalid_arguments() -> None:
    simulation = PadSimulation.of_scene(pad_scene())
    with pytest.raises(InputError, match="7 finite"):
        simulation.advance(np.zeros(6))
    with pytest.raises(InputError, match="duration"):
        simulation.advance(duration=0.0)
    with pytest.raises(InputError, match="prefix"):
        pad_scene((), (Arm(), Arm(prefix="right_")))
    with pytest.raises(InputError, match="differ"):
        pad_scene((PlacedObject(pen()), PlacedObject(pen())))
    with pytest.raises(InputError, match="mass"):
        PlacedObject(pen(), motion="free", mass=0.0)
    with pytest.raises(InputError, match="centre line"):
        cable(np.zeros((1, 3)), 0.003)


def test_padded_arm_has_pad_at_tool() -> None:
    model = padded_arm().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    assert data.site("pad").xpos[2] == pytest.approx(1.266 + 0.04)


def down(simulation: PadSimulation, speed: float) -> np.ndarray:
    """Return joint velocities that move the pad down."""
    return _velocity(simulation, [0.0, 0.0, -speed])


def aside(simulation: PadSimulation, speed: float) -> np.ndarray:
    """Return joint velocities that move the pad along the world's x-axis."""
    return _velocity(simulation, [speed, 0.0, 0.0])


def _velocity(simulation: PadSimulation, linear: list[float]) -> np.ndarray:
    model, data = simulation.model, simulation.data
    jacobian = np.zeros((6, model.nv))
    mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], model.site("pad").id)
    rows = jacobian[:, :7]
    return np.linalg.lstsq(rows, np.array([*linear, 0, 0, 0]), rcond=None)[0]
