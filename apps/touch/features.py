"""`eyehand experiment features`: methods for a contact's orientation and position."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from eyehand.data_synth.pad import TactileReadout, run_bench
from eyehand.tactile import FeatureReader, TactileArray, calibrate, calibrate_linear

from ..bench import machine_line
from ..bench.experiment import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .feature_chart import feature_chart
from .feature_comparison import (
    centre_rows,
    direction_rows,
    error_spread,
    lines_and_probes,
    reading_rows,
)
from .imprints import imprints

UNITS = {"orientation": "deg", "centre": "mm", "calibration": "mm"}
"""Feature → unit of its error."""
SYMBOLS = {"deg": "°", "mm": " mm"}
"""Unit → how it is printed after a number."""


def experiment_features(
    *,
    imprints: int | None = None,
    seed: int = 0,
    quick: bool = False,
    out: Path = Path("out/experiment_features"),
    json: bool = False,
) -> int:
    """Compare methods for the orientation and the position of a contact: accuracy against time.

    Lines and probes of 2 mm are pressed at random places into a simulated pad with noise. Half of
    the lines cross the pad. Orientation: second moments against the Hough transform. Position:
    centre of pressure against the centre of the touched tactels. Calibration: the full
    characteristic of each tactel against its linear range. Writes features.png and features.csv.

    Parameters
    ----------
    imprints
        Number of lines, and also of probes, >= 2. Default: 300.
    seed
        Imprint k uses seed + k.
    quick
        20 imprints, for a first look.
    out
        Output folder.
    json
        Print one JSON object on stdout. The table then goes to stderr.
    """
    return run_experiment(FEATURES, trials=imprints, seed=seed, quick=quick, out=out, json=json)


def _measure(plan: TrialPlan) -> ExperimentResult:
    array = TactileArray.flat()
    lines, probes = lines_and_probes(array, plan.trials, plan.seed)
    rows = [
        *direction_rows(array, lines),
        *centre_rows(probes),
        *calibration_rows(array, plan.trials, plan.seed),
        *reading_rows(array, lines),
    ]
    data = "lines (half of them crossing the pad) and 2 mm probes, 16 × 16 tactels, noise 5 Pa"
    table = result_table(
        [{**row, **_errors(row)} for row in rows],
        [
            ("", "{name}"),
            ("time", "{time_p50_us:.1f} µs"),
            ("median", "{p50}"),
            ("p95", "{p95}"),
            ("rms", "{rms}"),
        ],
        caption="time: median of one call from Python, without finding the contact region; other "
        "columns: errors; reading: from raw counts to all features; calibration: position of a "
        "probe, with non-linear characteristics, noise and 12 bits",
    )
    picture = feature_chart(rows, plan.provenance(data))
    return ExperimentResult(rows, table, picture, more={"machine": machine_line()})


def _errors(row: Mapping[str, Any]) -> dict[str, str]:
    """Return the errors of a row as text with their unit, by statistic."""
    unit = UNITS.get(row["feature"])
    if unit is None:
        return {}
    return {
        statistic: f"{row[f'error_{statistic}_{unit}']:.3f}{SYMBOLS[unit]}"
        for statistic in ("p50", "p95", "rms")
    }


FEATURES = Experiment(
    "features",
    _measure,
    unit="imprint",
    trials=300,
    quick_trials=20,
    min_trials=2,
    option="imprints",
)


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
