"""Synthetic frames: their list, repeatability and noise."""

import numpy as np
import pytest

from eyehand.apps.segmentation.synthetic_frames import (
    FAMILIES,
    NOISES,
    FurnishedContents,
    depth_noise,
    synthetic_sources,
)
from eyehand.data_synth.render import SENSORS, DepthNoise, axial_sigma
from eyehand.data_synth.scenes.fixture import BACKGROUND_NUMBER
from eyehand.errors import InputError


def test_lists_every_family_with_every_noise():
    sources = synthetic_sources(frames=2, seed=7)
    groups = {source.group for source in sources}
    assert groups == {f"{family}/{noise}" for family in FAMILIES for noise in NOISES}
    assert {"separate", "touching", "stacked", "empty"} <= set(FAMILIES)
    assert len(sources) == 2 * len(groups)
    assert len({source.name for source in sources}) == len(sources)


def test_frames_repeat_and_noises_share_scenes():
    clean, noisy = synthetic_sources(["separate"], ["none", "1mm"], frames=1, seed=3)
    first, again = noisy.load(), noisy.load()
    assert np.array_equal(first.frame.depth, again.frame.depth)
    noise_free = clean.load()
    assert np.array_equal(noise_free.truth, first.truth)
    assert noise_free.truth.max() >= 4
    assert first.frame.T_world_camera is not None
    # The noise at 1 m has the strength in its name.
    z = noise_free.frame.depth.astype(np.float64)
    valid = z > 0
    error = (first.frame.depth - z)[valid] / axial_sigma(z[valid]) * axial_sigma(np.array(1.0))
    assert np.std(error) == pytest.approx(1e-3, rel=0.01)


def test_empty_table_has_no_object_and_many_readings():
    (source,) = synthetic_sources(["empty"], ["realistic"], frames=1)
    read = source.load()
    assert read.truth.max() == 0
    assert np.mean(read.frame.valid) > 0.5


def test_empty_bin_shows_its_parts_and_no_object():
    (source,) = synthetic_sources(["empty-bin"], ["none"], frames=1)
    read = source.load()
    assert read.truth.max() == 0
    assert read.background is not None
    assert np.all((read.background > 0) == (read.frame.depth > 0))


def test_slivers_of_hidden_objects_are_not_scored():
    (source,) = synthetic_sources(["bin"], ["none"], frames=1, seed=3)
    read = source.load()
    assert read.ignored is not None
    counts = np.bincount(read.truth.ravel())
    small = np.flatnonzero((counts > 0) & (counts < 4e-4 * read.truth.size))
    assert set(np.unique(read.truth[read.ignored])) == set(small)


def test_contents_put_an_arm_into_the_view():
    (source,) = synthetic_sources(
        ["tray"], ["none"], frames=1, seed=2, contents=FurnishedContents(arm=True)
    )
    background = source.load().background
    assert background is not None
    assert np.count_nonzero(background == BACKGROUND_NUMBER["robot"]) > 1000


def test_returns_noise_by_name():
    assert depth_noise("none") == DepthNoise.none()
    assert depth_noise("realistic") == DepthNoise.realistic()
    assert depth_noise("oak") == SENSORS["oak"]
    assert depth_noise("realistic*2") == DepthNoise.realistic(2.0)
    axial = depth_noise("1.5mm")
    assert isinstance(axial, DepthNoise)
    assert axial == DepthNoise(axial=axial.axial)
    assert axial.axial * axial_sigma(np.array(1.0)) == pytest.approx(1.5e-3)


def test_rejects_unknown_names_and_numbers():
    with pytest.raises(InputError, match="'loud'"):
        depth_noise("loud")
    with pytest.raises(InputError, match="'floating'"):
        synthetic_sources(["floating"])
    with pytest.raises(InputError, match="--frames"):
        synthetic_sources(frames=0)
