"""The slip detector judges features with their past, as they arrive."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import SlipDetector, SlipScore, with_past
from eyehand.tactile.slip_detector import JUDGEMENT_LAGS


def test_past_of_a_sequence_starts_with_its_first_features():
    features = np.arange(20.0)[:, None]
    rows = with_past(features)
    assert rows.shape == (20, len(JUDGEMENT_LAGS))
    assert rows[0].tolist() == [0.0] * len(JUDGEMENT_LAGS)
    assert rows[15].tolist() == [15.0 - lag for lag in JUDGEMENT_LAGS]


def test_detector_judges_a_stream_as_a_whole_sequence():
    rng = np.random.default_rng(0)
    features = rng.normal(size=(40, 3))
    weights = rng.normal(size=3 * len(JUDGEMENT_LAGS))
    trained = SlipScore(lambda rows: rows @ weights, level=1.0)
    detector = SlipDetector(trained)
    # The features of a state are overwritten by its next image.
    buffer = np.zeros(3)
    alarms = []
    for row in features:
        buffer[:] = row
        alarms.append(detector.update(buffer))
    assert alarms == (trained.score(with_past(features)) > 1.0).tolist()


def test_level_must_be_a_number():
    with pytest.raises(InputError, match="level of an alarm"):
        SlipScore(lambda rows: rows[:, 0], float("nan"))
