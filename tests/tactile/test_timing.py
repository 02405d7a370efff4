"""Delay and lag identified from a press."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import identify_timing

DT = 0.004


def press(latency: int, lag: float, loop: float, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return commands and pressures of a press on a sensor with this timing and hysteresis."""
    time = np.arange(400) * DT
    commands = 0.01 * np.sin(2 * np.pi * 3 * time) + 0.012 * np.sin(2 * np.pi * 8 * time)
    commands[:25] = 0.02
    velocity, speed = np.zeros(400), 0.0
    for k in range(400):
        command = commands[k - latency] if k >= latency else 0.0
        speed += (1 - np.exp(-DT / lag)) * (command - speed)
        velocity[k] = speed
    depth = np.cumsum(velocity) * DT - 1e-3
    true = 8e5 * np.maximum(depth, 0.0) * (1 + 300 * np.maximum(depth, 0.0))
    load = np.maximum.accumulate(true)
    felt = true + loop * (load - true)
    felt += noise * np.random.default_rng(0).standard_normal(400) * (felt > 0)
    return commands, np.maximum(felt, 0.0)


@pytest.mark.parametrize(("latency", "lag"), [(1, 0.015), (3, 0.015), (6, 0.03)])
@pytest.mark.parametrize("loop", [0.0, 0.1])
def test_timing_is_identified(latency: int, lag: float, loop: float) -> None:
    timing = identify_timing(*press(latency, lag, loop, noise=5.0), DT)
    assert timing.latency == pytest.approx(latency, abs=1)
    total = timing.latency * DT + timing.lag
    assert total == pytest.approx(latency * DT + lag, abs=0.004)
    assert timing.residual < 0.1


def test_bad_presses_are_rejected() -> None:
    commands, pressures = press(1, 0.015, 0.0, 0.0)
    with pytest.raises(InputError, match="100 readings in contact, got 0"):
        identify_timing(commands, np.zeros(400), DT)
    with pytest.raises(InputError, match="must be"):
        identify_timing(commands[:10], pressures, DT)
    with pytest.raises(InputError, match="finite"):
        identify_timing(commands * np.nan, pressures, DT)
