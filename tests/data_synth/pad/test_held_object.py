"""An object held between two pads: balance, friction limits, slide, shear in the image."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.data_synth.pad import SENSORS, HeldObject, HeldSimulation
from eyehand.errors import InputError

SMOOTH = HeldObject(mass=0.2, friction=0.5, roughness=0.0, friction_spread=0.0)
GRIP = 3.0
LIMIT = 2 * 1.2 * SMOOTH.friction * GRIP
"""Largest load that static friction of both pads holds, N."""


def load(simulation: HeldSimulation, force: float, seconds: float = 0.2) -> None:
    """Raise a load along -y within half the time, and hold it."""
    count = int(seconds * 1900)
    for k in range(count):
        simulation.advance(GRIP, (0.0, -force * min(2 * k / count, 1.0)))


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_load_below_the_limit_is_held(share):
    simulation = HeldSimulation(SMOOTH, GRIP)
    load(simulation, share * LIMIT)
    assert simulation.slide < 1e-5
    assert simulation.friction_force == pytest.approx([0.0, 0.5 * share * LIMIT], abs=0.02)


def test_load_above_the_limit_slides():
    simulation = HeldSimulation(SMOOTH, GRIP)
    load(simulation, 1.15 * LIMIT)
    assert simulation.slide > 1e-3
    assert simulation.slipping > 0.99
    # Sliding friction is lower than static friction.
    assert np.hypot(*simulation.friction_force) == pytest.approx(SMOOTH.friction * GRIP, rel=0.02)


def test_curved_face_slides_at_its_rim_first():
    ball = replace(SMOOTH, curve_x=30.0, curve_y=30.0)
    simulation = HeldSimulation(ball, GRIP)
    load(simulation, 0.5 * LIMIT)
    assert 1e-5 < simulation.slide < 1e-4


def test_centre_of_mass_beside_the_face_turns_the_object():
    simulation = HeldSimulation(replace(SMOOTH, centre_x=0.006), GRIP)
    load(simulation, 0.5 * LIMIT)
    assert simulation.angle < -1e-3


def test_shear_moves_the_centre_of_pressure_by_the_lever():
    simulation = HeldSimulation(SMOOTH, GRIP, sensor=replace(SENSORS["ideal"], shear=1.0))
    load(simulation, 0.5 * LIMIT)
    pressures, shear = simulation.read()
    area = simulation.pitch**2
    assert pressures.sum() * area == pytest.approx(GRIP, rel=0.1)
    # The pad bears the load of its side.
    assert shear[:, 1].sum() * area == pytest.approx(-0.25 * LIMIT, rel=0.03)
    centre = pressures @ simulation.array.positions[:, 1] / pressures.sum()
    assert centre == pytest.approx(-0.004 * 0.25 * LIMIT / GRIP, rel=0.3)


def test_face_that_leaves_the_grip_is_free():
    simulation = HeldSimulation(SMOOTH, GRIP)
    for _ in range(1900):
        simulation.advance(0.0, (0.0, -1.0))
    assert simulation.slipping == 1.0
    assert np.isfinite(simulation.slide)


@pytest.mark.parametrize(
    "wrong", [{"mass": 0.0}, {"friction": -0.1}, {"half_x": np.nan}, {"roughness": np.inf}]
)
def test_objects_out_of_range_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        HeldObject(**wrong)


@pytest.mark.parametrize(("grip", "top"), [(0.0, 20e3), (1.0, -1.0), (np.nan, 20e3)])
def test_grips_and_ranges_out_of_range_are_refused(grip, top):
    with pytest.raises(InputError, match="grip and range must be > 0"):
        HeldSimulation(SMOOTH, grip, max_pressure=top)
