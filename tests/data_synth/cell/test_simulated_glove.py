"""A glove on the simulated hand: forces of each patch and of the whole hand in a grasp."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import SENSORS, run_bench
from eyehand.data_synth.scenes import TabletopObject
from eyehand.errors import InputError
from eyehand.perception.superquadric import Superquadric
from eyehand.tactile import FeatureOptions, HandFeatures, calibrate

from .glove_on_hand import MAX_LOAD_PA, SimulatedGlove
from .hand_bench import bench_grasp


def grasp_ball(sensor: str = "good") -> dict:
    """Grasp and lift a ball with a glove; return the features and the truth at the end."""
    shape = Superquadric(
        np.full(3, 0.0375), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.0375]), "sphere"
    )
    ball, found = TabletopObject("ball", shape, 0.10, (0.8, 0.3, 0.2)), {}

    def on_cycle(model, data) -> None:
        if "glove" not in found:
            glove = SimulatedGlove(model, data, "hand/", SENSORS[sensor], seed=1)
            calibration = calibrate(run_bench(glove.readout, max_load=MAX_LOAD_PA))
            found["glove"] = glove
            found["reader"] = glove.glove.reader(calibration, FeatureOptions(min_tactels=1))
        frame = found["glove"].read()
        assert frame is not None
        assert frame.time == data.time
        features = found["reader"].read(frame.raw)
        found["features"] = features
        found["poses"] = found["glove"].poses
        found["hand"] = HandFeatures.of_patches(features, found["poses"])
        found["truth"] = forces_on_ball(model, data)

    assert bench_grasp(ball, "power", on_cycle=on_cycle)
    return found


def forces_on_ball(model, data) -> dict[str, np.ndarray]:
    """Return the force of each phalanx and the palm on the ball, (3,), N, in the hand's frame."""
    axes = data.site("hand/palm").xmat.reshape(3, 3).T
    mujoco, wrench, forces = import_mujoco(), np.zeros(6), {}
    for k in range(data.ncon):
        contact = data.contact[k]
        names = [model.geom(int(geom)).name.removeprefix("hand/") for geom in contact.geom]
        mujoco.mj_contactForce(model, data, k, wrench)
        side = 1.0 if "ball" in names[1] else -1.0
        hand = names[0] if side > 0 else names[1]
        forces[hand] = forces.get(hand, np.zeros(3)) + side * wrench[0] * axes @ contact.frame[:3]
    return forces


@pytest.fixture(scope="module")
def grasp() -> dict:
    return grasp_ball()


def test_glove_has_patches_on_all_phalanges_and_the_palm(grasp):
    glove = grasp["glove"].glove
    fingers = {f"{f}_{link}" for f in ("index", "middle", "ring") for link in
               ("proximal", "middle", "distal")}  # fmt: skip
    assert set(glove.patches) == fingers | {"thumb_proximal", "thumb_distal", "palm_pad"}
    assert sum(len(array.positions) for array in glove.patches.values()) == len(
        glove.array.positions
    )


def test_each_patch_feels_the_force_on_its_link(grasp):
    touched = 0
    for name, features in grasp["features"].items():
        along = grasp["poses"][name].rotation.apply([0.0, 0.0, 1.0])
        true = max(float(along @ grasp["truth"].get(name, np.zeros(3))), 0.0)
        assert features.force == pytest.approx(true, rel=0.1, abs=0.15), name
        touched += bool(features)
    assert touched >= 5


def test_forces_of_a_grip_oppose_each_other(grasp):
    hand = grasp["hand"]
    assert hand.squeeze == pytest.approx(
        sum(np.linalg.norm(f) for f in grasp["truth"].values()), rel=0.1
    )
    assert hand.balance > 0.5
    assert "thumb_distal" in hand.touching or "thumb_proximal" in hand.touching
    # The centre is inside the ball, in front of the palm.
    assert np.linalg.norm(hand.centre - [0.0, 0.0, 0.0375]) < 0.03


def test_glove_with_the_real_sensor_feels_the_same_grip(grasp):
    real = grasp_ball("real")["hand"]
    assert real.squeeze == pytest.approx(grasp["hand"].squeeze, rel=0.25)
    assert set(real.touching) >= {name for name, f in grasp["features"].items() if f.force > 1.0}


def test_hand_without_contact_and_wrong_models(grasp):
    quiet = grasp["reader"].read(np.zeros(len(grasp["glove"].glove.array.positions), np.uint16))
    hand = HandFeatures.of_patches(quiet, {})
    assert not hand
    assert (hand.balance, hand.squeeze) == (0.0, 0.0)
    with pytest.raises(InputError, match="has no pose"):
        HandFeatures.of_patches(grasp["features"], {"palm_pad": RigidTransform.identity()})
    with pytest.raises(InputError, match="tactels like the glove"):
        grasp["glove"].glove.reader(calibrate(run_bench(SENSORS["good"].readout(16))))
    mujoco = import_mujoco()
    empty = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(InputError, match="no phalanges"):
        SimulatedGlove(empty, mujoco.MjData(empty))


def test_torque_is_about_the_origin_of_the_hand(grasp):
    name = grasp["hand"].touching[0]
    features = {name: grasp["features"][name]}
    pose = RigidTransform.from_components([0.1, 0.0, 0.0], Rotation.identity())
    hand = HandFeatures.of_patches(features, {name: pose})
    expected = np.cross(features[name].centre + np.array([0.1, 0, 0]), hand.force)
    assert np.allclose(hand.torque, expected)
