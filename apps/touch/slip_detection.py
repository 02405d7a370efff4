"""Detect slip in simulated trials: what is trained, when an alarm counts, and the rates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.tactile import PRESSURE_FEATURES, with_past

from .slip_network import train_network
from .slip_trials import SlipTrial

SLIP_SLIDE = 1e-4
"""True slide from which a trial counts as slip, m."""
CLEAR_SLIDE, LONG_SLIDE = 2e-4, 5e-4
"""True slides of slips that are reported apart, m: shorter ones often end by themselves."""
FIRST_SLIDE = 1e-5
"""True slide from which an alarm is no longer early, m."""
EARLY, LATE = 0.01, 0.05
"""Time before the first slide, and after `SLIP_SLIDE`, within which an alarm counts, s."""
FALSE_SHARE = 0.01
"""Share of the trials without slip in which an alarm is allowed."""
_RECENT, _CALM_SLIDE, _RECENT_SLIDE = 24, 2e-5, 8e-5
"""A judgement is one of slip if the face has slid the second distance, m, within so many
judgements, and one of no slip below the first one. Those in between are not trained on."""
_LAST_SLIDE = 1.5e-3
"""Slide up to which a judgement is trained on, m: later ones come too late."""
_EVERY = 4
"""One of so many judgements without slip is trained on."""
_DECAY, _ITERATIONS = 3e-3, 200
_SPECTRUM_FLOOR = 1e-4
"""Amplitude below which the spectrum is noise, as a share of the pressure."""


def _fourier(trial: SlipTrial) -> NDArray[np.float64]:
    return np.log(trial.spectra + _SPECTRUM_FLOOR).astype(float)


def _pressure(trial: SlipTrial) -> NDArray[np.float64]:
    return with_past(trial.features[:, :PRESSURE_FEATURES])


def _pressure_and_shear(trial: SlipTrial) -> NDArray[np.float64]:
    return with_past(trial.features)


DETECTORS: dict[str, Callable[[SlipTrial], NDArray[np.float64]]] = {
    "Fourier (chapter)": _fourier,
    "pressure patterns": _pressure,
    "with a shear array": _pressure_and_shear,
}
"""Detector → its features (T, K) of a trial."""


@dataclass(frozen=True)
class Alarms:
    """Alarms of one detector in M trials."""

    detected: NDArray[np.bool_]
    """(M,): whether the alarm of a trial with slip came in time."""
    alarmed: NDArray[np.bool_]
    """(M,): whether there was any alarm."""
    latency: NDArray[np.float64]
    """Time from `SLIP_SLIDE` to the alarm of each detected slip, s; negative before it."""
    slide: NDArray[np.float64]
    """True slide at the alarm of each detected slip, m."""


def train_detector(
    name: str, trials: Sequence[SlipTrial], seed: int
) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Train a detector, and return the function from its features (M, K) to scores, (M,)."""
    features = DETECTORS[name]
    values, labels = [], []
    for trial in trials:
        slides = trial.slide
        past = slides[np.maximum(np.arange(len(slides)) - _RECENT, 0)]
        slid = slides - past
        slips = (slid > _RECENT_SLIDE) & has_slip(trial)
        used = (slides < _LAST_SLIDE) & (slips | (slid < _CALM_SLIDE) | (not has_slip(trial)))
        used &= slips | (np.arange(len(slides)) % _EVERY == 0)
        values.append(features(trial)[used])
        labels.append(slips[used])
    network = train_network(
        np.vstack(values),
        np.concatenate(labels).astype(np.int64),
        seed,
        classes=2,
        decay=_DECAY,
        iterations=_ITERATIONS,
    )

    def score(given: NDArray[np.float64]) -> NDArray[np.float64]:
        outputs = network(given)
        return outputs[:, 1] - outputs[:, 0]

    return score


def score_trials(
    name: str,
    score: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    trials: Sequence[SlipTrial],
) -> list[NDArray[np.float64]]:
    """Return the scores (T,) of each trial by a trained detector."""
    return [score(DETECTORS[name](trial)) for trial in trials]


def has_slip(trial: SlipTrial) -> bool:
    """Return whether the face slid by more than `SLIP_SLIDE`."""
    return bool(trial.slide[-1] > SLIP_SLIDE)


def alarm_level(trials: Sequence[SlipTrial], scores: Sequence[NDArray[np.float64]]) -> float:
    """Return the score above which `FALSE_SHARE` of the trials without slip raise an alarm."""
    calm = [s.max() for trial, s in zip(trials, scores, strict=True) if not has_slip(trial)]
    return float(np.quantile(calm, 1 - FALSE_SHARE)) if calm else 0.0


def judge_alarms(
    trials: Sequence[SlipTrial], scores: Sequence[NDArray[np.float64]], level: float
) -> Alarms:
    """Compare the first alarm of each trial with the true slide."""
    detected, alarmed, latency, slide = [], [], [], []
    for trial, score in zip(trials, scores, strict=True):
        above = score > level
        alarmed.append(bool(above.any()))
        if not has_slip(trial) or not above.any():
            detected.append(False)
            continue
        first = int(above.argmax())
        begun = trial.time[int((trial.slide > FIRST_SLIDE).argmax())]
        slid = trial.time[int((trial.slide > SLIP_SLIDE).argmax())]
        in_time = bool(begun - EARLY <= trial.time[first] <= slid + LATE)
        detected.append(in_time)
        if in_time:
            latency.append(trial.time[first] - slid)
            slide.append(trial.slide[first])
    return Alarms(np.array(detected), np.array(alarmed), np.array(latency), np.array(slide))


def detection_row(trials: Sequence[SlipTrial], alarms: Alarms) -> dict[str, Any]:
    """Return rates (%), latencies (ms) and slides (mm) as one row; None where there is none."""
    slips = np.array([has_slip(trial) for trial in trials])
    final = np.array([trial.slide[-1] for trial in trials])
    clear, long = final > CLEAR_SLIDE, final > LONG_SLIDE
    knocks = ~slips & np.array([trial.event in ("knock", "acceleration") for trial in trials])
    times, slides = 1e3 * alarms.latency, 1e3 * alarms.slide
    return {
        "slips": int(slips.sum()),
        "calm": int((~slips).sum()),
        "detected_pct": _percentage(alarms.detected[slips]),
        "clear_slips": int(clear.sum()),
        "clear_detected_pct": _percentage(alarms.detected[clear]),
        "long_slips": int(long.sum()),
        "long_detected_pct": _percentage(alarms.detected[long]),
        "false_pct": _percentage(alarms.alarmed[~slips]),
        "knocks": int(knocks.sum()),
        "false_knocks_pct": _percentage(alarms.alarmed[knocks]),
        "latency_ms": float(np.median(times)) if len(times) else None,
        "latency_p99_ms": float(np.quantile(times, 0.99)) if len(times) else None,
        "slide_mm": float(np.median(slides)) if len(slides) else None,
        "slide_p99_mm": float(np.quantile(slides, 0.99)) if len(slides) else None,
    }


def _percentage(flags: NDArray[np.bool_]) -> float | None:
    return 100 * float(flags.mean()) if len(flags) else None
