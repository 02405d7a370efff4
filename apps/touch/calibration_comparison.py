"""How much of a probe's place is left after the read-out, by the way the pad was calibrated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.data_synth.pad import TactileReadout, run_bench
from eyehand.tactile import FeatureReader, calibrate, calibrate_linear

from .feature_comparison import error_spread
from .imprints import imprints

if TYPE_CHECKING:
    from eyehand.tactile import TactileArray


def calibration_rows(array: TactileArray, count: int, seed: int) -> list[dict[str, Any]]:
    """Press `count` probes into one pad, calibrated on its bench in both ways.

    Returns
    -------
    list of dict
        Rows `calibration full curve` and `calibration linear range`, the paper's: error of the
        centre of pressure, of single images.
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
            gap = reader.read(raw).centre[:2] - probe.centre
            errors[name].append(1e3 * float(np.linalg.norm(gap)))
    return [
        {
            "name": f"calibration {name}",
            "feature": "calibration",
            "method": name,
            **error_spread("mm", each),
        }
        for name, each in errors.items()
    ]
