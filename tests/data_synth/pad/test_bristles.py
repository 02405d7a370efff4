"""Static friction of the simulated pad: closed forms, and the kernel against NumPy."""

import numpy as np
import pytest

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import SENSORS, Foam, PadOptions, TactilePad
from eyehand.data_synth.pad.bristles import (
    AREA,
    BEND_X,
    BEND_Y,
    BRISTLE_FIELDS,
    FLOW_X,
    FLOW_Y,
    RATIO,
    STATIC_RATIO,
    bend_bristles,
)

mujoco = import_mujoco()
FRICTION = 0.6
STIFFNESS = 0.5 * Foam().modulus / Foam().thickness
STEP = 1.0 / 1900.0


class Sheared:
    """A pad with real friction under an object that slides along x."""

    def __init__(self, geom: str) -> None:
        self.model = mujoco.MjModel.from_xml_string(
            '<mujoco><worldbody><body name="pad"><site name="pad"/></body>'
            f'<body name="object" mocap="true">{geom}</body></worldbody></mujoco>'
        )
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.pad = TactilePad(
            self.model, self.data, options=PadOptions(friction=FRICTION), sensor=SENSORS["real"]
        )
        self.pad.contact()

    def slide(self, distance: float, speed: float) -> None:
        """Move the object along x by a distance, m, at a speed, m/s."""
        steps = round(abs(distance) / (speed * STEP))
        for _ in range(steps):
            self.data.mocap_pos[0, 0] += distance / steps
            self.data.time += STEP
            mujoco.mj_kinematics(self.model, self.data)
            self.pad.contact()

    def rest(self) -> None:
        """Wait for three steps."""
        mujoco.mj_kinematics(self.model, self.data)
        for _ in range(3):
            self.data.time += STEP
            self.pad.contact()


def plate(depth: float = 1e-3) -> Sheared:
    """Return a plate of 40 by 40 mm at a depth in the foam."""
    return Sheared(f'<geom type="box" size=".02 .02 .01" pos="0 0 {0.01 - depth}"/>')


@pytest.mark.parametrize("bend", [2e-5, 1e-4, 4e-4])
def test_plate_that_sticks_is_a_spring(bend: float) -> None:
    world = plate()
    world.slide(bend, 2e-3)
    world.rest()
    assert -world.pad.wrench[0] == pytest.approx(STIFFNESS * 0.04**2 * bend, rel=2e-3)
    assert world.pad.slip_share == 0.0


def test_plate_holds_its_load_at_rest() -> None:
    world = plate()
    world.slide(3e-4, 2e-3)
    world.rest()
    held = world.pad.wrench[0]
    for _ in range(3000):
        world.data.time += STEP
        world.pad.contact()
    assert world.pad.wrench[0] == pytest.approx(held, rel=1e-9)


def test_plate_breaks_away_at_static_and_slides_at_kinetic_friction() -> None:
    world = plate()
    world.slide(1.5e-3, 0.05)
    peak = 0.0
    for _ in range(40):
        world.slide(1e-5, 3e-4)
        peak = max(peak, -world.pad.wrench[0] / world.pad.force)
    assert peak == pytest.approx(STATIC_RATIO * FRICTION, rel=0.01)
    world.slide(5e-3, 0.05)
    assert -world.pad.wrench[0] / world.pad.force == pytest.approx(FRICTION, rel=1e-3)
    assert world.pad.slip_share > 0.99


def test_reversed_plate_loses_its_bend_first() -> None:
    world = plate()
    world.slide(5e-3, 0.05)
    world.slide(-1e-4, 2e-3)
    world.rest()
    expected = FRICTION * world.pad.force - STIFFNESS * 0.04**2 * 1e-4
    # The last sliding step ends at a lower speed, with a friction between the two limits.
    assert -world.pad.wrench[0] == pytest.approx(expected, rel=0.03)


def test_ball_slips_from_the_rim_inwards() -> None:
    world = Sheared('<geom type="sphere" size=".03" pos="0 0 .029"/>')
    shares = []
    for _ in range(8):
        world.slide(2.2e-4, 5e-3)
        shares.append(world.pad.slip_share)
    assert shares == sorted(shares)
    assert 0.0 < shares[1] < 0.5
    assert shares[-1] == pytest.approx(1.0, abs=0.02)


def test_lifted_object_straightens_the_bristles() -> None:
    world = plate()
    world.slide(3e-4, 2e-3)
    world.data.mocap_pos[0, 2] += 0.02
    world.rest()
    world.data.mocap_pos[0, 2] -= 0.02
    mujoco.mj_kinematics(world.model, world.data)
    world.pad.contact()
    assert world.pad.wrench[0] == pytest.approx(0.0, abs=1e-12)


def test_centre_of_image_moves_by_lever() -> None:
    world = plate()
    world.slide(3e-4, 2e-3)
    world.rest()
    pad = world.pad
    forces = pad.true_pressures * pad.array.area
    assert forces.sum() == pytest.approx(pad.force)
    moved = forces @ pad.array.positions[:, 0] / pad.force - pad.centre[0]
    expected = Foam().thickness * -pad.wrench[0] / pad.force
    assert moved == pytest.approx(expected, abs=2e-5)
    assert expected > 1e-4


def test_kernel_equals_numpy() -> None:
    rng = np.random.default_rng(2)
    grid = rng.uniform(0, 0.02, (3, 12, 10))
    grid[0, :3] = 0.0
    bristles = np.zeros((BRISTLE_FIELDS, 12, 10))
    bristles[[BEND_X, BEND_Y]] = rng.normal(0, 2e-4, (2, 12, 10))
    bristles[RATIO] = 1.0
    bristles[AREA] = rng.uniform(0, 6e-6, (12, 10)) * (rng.random((12, 10)) < 0.8)
    bristles[[FLOW_X, FLOW_Y]] = rng.normal(0, 2e-5, (2, 12, 10)) * (bristles[AREA] > 0)
    bed = np.array([0.03, 0.04, 0.004, 0.002, FRICTION, 0.005, STIFFNESS])
    push, area = grid[0], bristles[AREA].copy()
    live = (push > 0) & (area > 0)
    with np.errstate(all="ignore"):
        ratio = STIFFNESS * area / push
        flow = bristles[[FLOW_X, FLOW_Y]] / push
        bend = bristles[[BEND_X, BEND_Y]] + STEP * flow
        speed = np.hypot(*flow) / 0.002
        limit = FRICTION * (1 + (STATIC_RATIO - 1) * np.exp(-(speed**2))) / ratio
        size = np.hypot(*bend)
        expected = np.where(live, bend * np.minimum(1.0, limit / size), 0.0)
    share = push[live & (size > 0.999 * limit)].sum() / push[live].sum()
    assert bend_bristles(grid, bed, STEP, bristles) == pytest.approx(share)
    assert bristles[[BEND_X, BEND_Y]] == pytest.approx(expected, abs=1e-15)
    assert not bristles[AREA:].any()
