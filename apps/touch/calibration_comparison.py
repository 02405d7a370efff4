"""Compare the position error of a probe for two calibration methods of the pad."""

from __future__ import annotations

from typing import Any

import numpy as np

from eyehand.data_synth.pad import TactileReadout, run_bench
from eyehand.tactile import FeatureReader, TactileArray, calibrate, calibrate_linear

from .feature_comparison import error_spread
from .imprints import imprints


def calibration_rows(array: TactileArray, count: int, seed: int) -> list[dict[str, Any]]:
    """Press `count` probes into one pad that was calibrated with both methods.

    Returns
    -------
    list of dict
        Rows `calibration full curve` and `calibration linear range` (the paper's method): error of
        the centre of pressure in single images.
    """
    readout = TactileReadout.draw(len(array.positions), seed=seed)
    run = run_bench(readout, seed=seed)
    readers = {
        "full curve": FeatureReader(calibrate(run), array),
        "linear range": FeatureReader(calibrate_linear(run), array),
    }
    errors: dict[str, list[float]] = {name: [] for name in readers}
    rng = np.random.default_rng(seed)
    for probe in imprints(array, "probe", count, seed, noise=0.0):
        raw = readout.raw(probe.image.pressures, rng)
        for name, reader in readers.items():
            reader.reset()
            error = reader.read(raw).centre[:2] - probe.centre
            errors[name].append(1e3 * float(np.linalg.norm(error)))
    return [
        {
            "name": f"calibration {name}",
            "feature": "calibration",
            "method": name,
            **error_spread("mm", each),
        }
        for name, each in errors.items()
    ]
