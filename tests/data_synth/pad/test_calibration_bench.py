"""The simulated calibration bench: its recordings calibrate the simulated pad."""

import numpy as np
import pytest

from eyehand.data_synth.pad import TactileReadout, run_bench
from eyehand.errors import InputError
from eyehand.tactile import calibrate


def test_bench_run_calibrates_pad() -> None:
    readout = TactileReadout.draw(seed=4, dead=(9,))
    calibration = calibrate(run_bench(readout, seed=5))
    assert np.flatnonzero(calibration.dead).tolist() == [9]
    live = np.arange(256) != 9
    for pressure in (300.0, 1e3, 5e3):
        found = calibration.to_pressure(readout.raw(np.full(256, pressure), None))[live]
        assert found.mean() == pytest.approx(pressure, rel=0.01)
        assert found.std() < 0.02 * pressure


def test_bench_run_is_repeatable_and_starts_at_rest() -> None:
    readout = TactileReadout.draw()
    first, again, other = (
        run_bench(readout, seed, loads=12, images=2, images_at_rest=5) for seed in (1, 1, 2)
    )
    assert first.raw.shape == (29, 256)
    assert (first.pressures[:5] == 0).all()
    assert (np.diff(first.pressures[4::2]) > 0).all()
    assert (first.raw == again.raw).all()
    assert (first.raw != other.raw).any()


def test_run_bench_rejects_invalid_arguments() -> None:
    with pytest.raises(InputError, match="loads"):
        run_bench(TactileReadout.draw(4), loads=0)
    with pytest.raises(InputError, match="seed"):
        run_bench(TactileReadout.draw(4), seed=-1)
