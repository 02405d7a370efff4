"""Inputs of the fit command: clouds, frames and rejected files."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from eyehand.apps.fitting.fit_inputs import CloudInput, FrameInput, read_inputs
from eyehand.errors import InputError
from eyehand.perception import FitOptions, perceive, read_frame, write_cloud, write_frame

SAMPLE = Path(__file__).resolve().parents[3] / "apps" / "sample" / "depth.png"


@pytest.fixture
def cloud(tmp_path) -> Path:
    return write_cloud(tmp_path / "c.ply", np.random.default_rng(0).normal(size=(60, 3)))


def test_cloud_keeps_camera_position_and_plane(cloud):
    plane = np.array([0.0, 0.0, 1.0, 0.1])
    (item,) = read_inputs([cloud], view_origin=(0.0, 0.0, 1.0), support_plane=plane)
    assert isinstance(item, CloudInput)
    assert item.cloud.points.shape == (60, 3)
    assert item.stems == ("c",)
    assert item.cloud.view_origin == pytest.approx([0.0, 0.0, 1.0])
    assert item.cloud.support_plane == pytest.approx(plane)


def test_frame_object_is_fitted_as_in_perceive():
    (item,) = read_inputs([SAMPLE], labels=[2])
    assert isinstance(item, FrameInput)
    (fitted,) = item.fitted(FitOptions())
    scene = perceive(read_frame(SAMPLE))
    found, expected = fitted.fit.superquadric, scene.objects[1].fit.superquadric
    assert found is not None
    assert expected is not None
    assert found.kind == expected.kind
    assert found.semi_axes == pytest.approx(expected.semi_axes)
    assert fitted.cloud.stem == "depth_2"
    assert fitted.cloud.view_origin == pytest.approx(scene.view_origin)
    assert scene.support is not None
    assert fitted.cloud.support_plane == pytest.approx(
        np.append(scene.support.normal, scene.support.offset)
    )


@pytest.mark.parametrize("suffix", [".npz", ".pcd", ".ply"])
def test_every_frame_format_lists_its_labels(tmp_path, suffix):
    path = tmp_path / f"frame{suffix}"
    write_frame(path, read_frame(SAMPLE))
    with pytest.raises(InputError, match=r"--label from 1 \(\d+ px\), 2 \(\d+ px\)"):
        read_inputs([path])
    (item,) = read_inputs([path], labels=[1, 3, 1])
    assert item.stems == ("frame_1", "frame_3")


def test_label_0_selects_all_readings():
    (item,) = read_inputs([SAMPLE], labels=[0])
    frame = read_frame(SAMPLE)
    assert isinstance(item, CloudInput)
    assert len(item.cloud.points) == np.count_nonzero(frame.valid)
    assert frame.T_world_camera is not None
    assert item.cloud.view_origin == pytest.approx(frame.T_world_camera.translation)


def test_archive_with_points_and_depth_is_a_cloud_unless_labelled(tmp_path):
    write_frame(tmp_path / "f.npz", read_frame(SAMPLE))
    held = dict(np.load(tmp_path / "f.npz"))
    np.savez(tmp_path / "both.npz", points=np.random.default_rng(0).random((80, 3)), **held)
    assert isinstance(read_inputs([tmp_path / "both.npz"])[0], CloudInput)
    assert isinstance(read_inputs([tmp_path / "both.npz"], labels=[1])[0], FrameInput)


def test_options_for_the_other_input_kind_are_rejected(cloud, tmp_path):
    with pytest.raises(InputError, match="--label is for depth frames"):
        read_inputs([cloud], labels=[1])
    with pytest.raises(InputError, match="--camera is for depth frames"):
        read_inputs([cloud], camera=tmp_path / "camera.json")
    with pytest.raises(InputError, match="has its own"):
        read_inputs([SAMPLE], labels=[1], view_origin=(0, 0, 1))
    with pytest.raises(InputError, match="no object 99: there are 1"):
        read_inputs([SAMPLE], labels=[99])
    with pytest.raises(InputError, match="no object -1"):
        read_inputs([SAMPLE], labels=[-1])
    with pytest.raises(InputError, match="is not supported"):
        read_inputs([tmp_path / "scene.blend"])
    shutil.copy(SAMPLE, tmp_path / "alone.png")
    with pytest.raises(InputError, match="camera"):
        read_inputs([tmp_path / "alone.png"], labels=[1])


def test_frame_without_objects_is_rejected(tmp_path):
    frame = read_frame(SAMPLE)
    columns = np.linspace(1.0, 1.001, frame.depth.shape[1], dtype=np.float32)
    wall = type(frame)(np.tile(columns, (frame.depth.shape[0], 1)), frame.intrinsics)
    write_frame(tmp_path / "wall.npz", wall)
    with pytest.raises(InputError, match="shows no object"):
        read_inputs([tmp_path / "wall.npz"])
