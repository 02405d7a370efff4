"""The noise of the clutter-removal protocol."""

from __future__ import annotations

import numpy as np

from eyehand.data_synth.render import add_dex_noise

DEPTH = np.full((120, 160), 0.6, np.float32)


def test_scale_and_blotches_have_their_spread():
    images = [add_dex_noise(DEPTH, np.random.default_rng(seed)) for seed in range(300)]
    scales = np.array([np.median(image) for image in images]) / 0.6
    assert abs(scales.mean() - 1.0) < 0.006
    assert 0.028 < scales.std() < 0.036
    blotched = np.array([image.std() > 1e-4 for image in images])
    assert 0.4 < blotched.mean() < 0.6
    # Bilinear interpolation between values of 5 mm averages some of them.
    spread = np.median([image.std() for image in np.array(images)[blotched]])
    assert 0.002 < spread < 0.005


def test_missing_readings_stay_missing():
    depth = DEPTH.copy()
    depth[:10] = 0.0
    noisy = add_dex_noise(depth, np.random.default_rng(1))
    assert (noisy[:10] == 0).all()
    assert (noisy[10:] > 0).all()
    assert noisy.dtype == np.float32
