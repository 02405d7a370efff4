"""Scenes of a table without objects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from eyehand.data_synth import (
    DepthNoise,
    TabletopOptions,
    make_scene,
    read_ground_truth,
    render_frame,
    write_scene,
)

EMPTY = TabletopOptions(count_range=(0, 0))


def test_empty_table_has_no_labels():
    scene = make_scene(0, EMPTY)
    frame, labels = render_frame(scene, DepthNoise.realistic(), 0)
    assert scene.objects == ()
    assert labels.max() == 0
    assert frame.valid.mean() > 0.5


@pytest.mark.parametrize("seed", range(5))
def test_camera_of_empty_table_points_at_work_area(seed: int):
    options = TabletopOptions(count_range=(0, 0), table_height=0.3)
    T_world_camera = make_scene(seed, options).T_world_camera
    forward = T_world_camera.rotation.apply([0.0, 0.0, 1.0])
    distance = (0.3 - T_world_camera.translation[2]) / forward[2]
    spot = T_world_camera.translation + distance * forward
    assert options.view.distance_range[0] <= distance <= options.view.distance_range[1]
    assert np.all(np.abs(spot[:2]) <= np.array(options.work_area) / 2)
    low, high = options.view.elevation_range
    assert low <= np.arcsin(-forward[2]) <= high


def test_camera_of_empty_table_is_repeatable_with_seed():
    one, again, other = (make_scene(seed, EMPTY).T_world_camera.as_matrix() for seed in (1, 1, 2))
    assert one.tobytes() == again.tobytes()
    assert not np.allclose(one, other)


def test_count_range_from_zero_gives_empty_and_occupied_tables():
    counts = [
        len(make_scene(seed, TabletopOptions(count_range=(0, 1))).objects) for seed in range(8)
    ]
    assert set(counts) == {0, 1}


def test_empty_scene_is_read_back(tmp_path: Path):
    scene = make_scene(3, EMPTY)
    write_scene(tmp_path, scene, *render_frame(scene))
    loaded = read_ground_truth(tmp_path)
    assert loaded.objects == ()
    assert (loaded.family, loaded.seed, loaded.table) == ("separate", 3, scene.table)
