"""The wood texture: range and hue of its colours."""

from __future__ import annotations

import numpy as np

from eyehand.data_synth.scenes.wood_texture import wood_colour


def test_wood_colours_are_in_range_and_brown():
    x, y = np.meshgrid(np.linspace(-2, 2, 200), np.linspace(-1, 1, 150))
    colour = wood_colour(x, y)
    assert colour.shape == (150, 200, 3)
    assert colour.min() > 0
    assert colour.max() < 1
    assert np.all(colour[..., 0] > colour[..., 1])
    assert np.all(colour[..., 1] > colour[..., 2])
    assert colour.std(axis=(0, 1)).min() > 0.02
