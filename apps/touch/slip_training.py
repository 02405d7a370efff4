"""Train a slip detector, and choose the level of its alarm on objects of a kind it did not see."""

from __future__ import annotations

from collections.abc import Sequence

from eyehand.data_synth.pad import SensorModel
from eyehand.tactile import SlipScore

from .slip_detection import alarm_level, score_trials, train_detector
from .slip_trials import EVENTS, PADS, TRAIN_SHAPES, SlipTrial, run_slip_trial

SEED_GAP = 100_000
"""Difference of the seeds of training and test, so that no surface and no noise is in both."""


def slip_trials(
    shapes: Sequence[str],
    count: int,
    seed: int,
    sensor: SensorModel,
    max_pressure: float,
    pads: Sequence[int] = PADS,
) -> dict[str, list[SlipTrial]]:
    """Run `count` trials of each event, with the kinds of objects and the pads in turn.

    Returns
    -------
    dict
        Kind of object → its trials.
    """
    trials: dict[str, list[SlipTrial]] = {shape: [] for shape in shapes}
    for k in range(count):
        shape = shapes[k % len(shapes)]
        trials[shape] += [
            run_slip_trial(shape, event, seed + k, sensor, max_pressure, pads[k % len(pads)])
            for event in EVENTS
        ]
    return trials


def all_of(trials: dict[str, list[SlipTrial]]) -> list[SlipTrial]:
    """Return the trials of all kinds."""
    return [trial for kind in trials.values() for trial in kind]


def left_out_level(name: str, trials: dict[str, list[SlipTrial]], seed: int) -> float:
    """Return the alarm level of a detector from trials of kinds that it was not trained on.

    Each kind is scored by a detector that is trained on the others.
    """
    scored, scores = [], []
    for shape, kind in trials.items():
        others = [trial for other, ones in trials.items() if other != shape for trial in ones]
        score = train_detector(name, others, seed)
        scored += kind
        scores += score_trials(name, score, kind)
    return alarm_level(scored, scores)


def trained_score(
    name: str, count: int, seed: int, sensor: SensorModel, max_pressure: float
) -> SlipScore:
    """Run trials of the kinds `TRAIN_SHAPES` on `PADS`, and train a detector with its level.

    The trials' seeds begin at `seed` + `SEED_GAP`.
    """
    trials = slip_trials(TRAIN_SHAPES, count, seed + SEED_GAP, sensor, max_pressure)
    score = train_detector(name, all_of(trials), seed)
    return SlipScore(score, left_out_level(name, trials, seed))
