"""Labelled frames in folders: reading, assumptions, rejected files."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from eyehand.apps.segmentation.dataset import (
    DatasetOptions,
    LabelledFrame,
    decode_labels,
    open_dataset,
)
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, write_intrinsics
from eyehand.perception.io import write_png

SAMPLE = Path(__file__).resolve().parents[3] / "apps" / "sample"
SIZE = (480, 640)


def archive(path: Path, **changes) -> Path:
    """Write a wall at 0.8 m in units of 0.1 mm with a box. Arrays that are None are left out."""
    depth = np.full(SIZE, 8000, np.uint16)
    label = np.ones(SIZE, np.uint8)
    label[100:200, 100:200] = 20
    label[100:200, 300:320] = 21
    arrays: dict[str, Any] = {"depth": depth, "label": label, **changes}
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


def only_frame(folder: Path, **options) -> LabelledFrame:
    (source,) = open_dataset(folder, DatasetOptions(**options))
    return source.load()


def test_reads_camera_and_unit_from_camera_file(tmp_path):
    archive(tmp_path / "a.npz", rgb=np.zeros((*SIZE, 3), np.uint8))
    camera = CameraIntrinsics(500.0, 501.0, 320.0, 240.0, 640, 480)
    write_intrinsics(tmp_path / "camera.json", camera, depth_scale_mm=0.1)
    read = only_frame(tmp_path, labels="osd")
    assert read.frame.intrinsics == camera
    assert np.allclose(read.frame.depth, 0.8)
    assert read.frame.colour is not None
    assert np.unique(read.truth).tolist() == [0, 2]
    assert np.count_nonzero(read.truth) == 100 * 100 + 100 * 20
    assert read.assumed == ()


def test_assumes_kinect_but_no_unit(tmp_path):
    archive(tmp_path / "a.npz")
    read = only_frame(tmp_path, labels="osd", depth_scale_mm=0.1)
    assert read.frame.intrinsics.fx == 525.0
    assert any("--camera" in note for note in read.assumed)
    with pytest.raises(InputError, match=r"--depth-scale-mm.*0\.1 \(median reading 0\.80 m\)"):
        only_frame(tmp_path, labels="osd")
    with pytest.raises(InputError, match=r"8 m.*--depth-scale-mm.*0\.1"):
        only_frame(tmp_path, labels="osd", depth_scale_mm=1.0)


def test_reads_archive_with_camera_and_unit(tmp_path):
    archive(
        tmp_path / "a.npz",
        depth=np.full((48, 64), 1600, np.uint16),
        label=np.eye(48, 64, dtype=np.int32),
        intrinsics=np.array([50.0, 50.0, 31.5, 23.5]),
        depth_scale_m=np.array(0.0005),
    )
    read = only_frame(tmp_path)
    assert (read.frame.intrinsics.fx, read.frame.intrinsics.width) == (50.0, 64)
    assert np.allclose(read.frame.depth, 0.8)
    assert read.truth.sum() == 48


def test_suggests_other_label_coding(tmp_path):
    label = np.ones(SIZE, np.uint8)
    label[100:200, 100:200] = 20
    archive(tmp_path / "a.npz", label=label)
    notes = only_frame(tmp_path, depth_scale_mm=0.1).assumed
    assert any("--labels osd" in note for note in notes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"label": None}, "`label`"),
        ({"depth": None}, "`depth`"),
        ({"label": np.zeros((480, 641), np.uint8)}, "480, 641"),
        ({"label": np.zeros(SIZE)}, "integers"),
        ({"label": np.full(SIZE, -3)}, "-3"),
        ({"depth": np.zeros(SIZE, np.uint16)}, "no reading"),
        ({"depth": np.full(SIZE, 800.0)}, "millimetres"),
        ({"depth": np.full(SIZE, 0.02, np.float32)}, "0.02 m"),
        ({"depth": np.full((2, 3, 4), 800, np.uint16)}, "2, 3, 4"),
        ({"depth": np.full((48, 64), 800, np.uint16), "label": None}, "`label`"),
        ({"intrinsics": np.ones(3)}, "fx, fy, cx, cy"),
        ({"depth_scale_m": np.array(-1.0)}, "more than 0"),
    ],
)
def test_rejects_invalid_archive_with_its_name(tmp_path, changes, message):
    archive(tmp_path / "invalid.npz", **changes)
    depth = changes.get("depth", np.zeros(1, np.uint16))
    options = {} if "depth_scale_m" in changes or depth is None else {"depth_scale_mm": 0.1}
    if depth is not None and depth.dtype.kind == "f":
        options = {}
    with pytest.raises(InputError, match=message) as error:
        only_frame(tmp_path, **options)
    assert "invalid.npz" in str(error.value)
    assert "\n" not in str(error.value)


def test_rejects_unknown_camera_size(tmp_path):
    archive(
        tmp_path / "a.npz", depth=np.full((48, 64), 800, np.uint16), label=np.zeros((48, 64), int)
    )
    with pytest.raises(InputError, match="--camera"):
        only_frame(tmp_path, depth_scale_mm=1.0)


def test_rejects_folders_without_frames(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        open_dataset(tmp_path / "absent")
    with pytest.raises(InputError, match="neither"):
        open_dataset(tmp_path)


def test_groups_are_folders_or_osd_ranges(tmp_path):
    (tmp_path / "more").mkdir()
    for name in ("learn9", "learn10", "learn17", "learn44", "test65", "other", "more/x"):
        archive(tmp_path / f"{name}.npz")
    sources = open_dataset(tmp_path, DatasetOptions(labels="osd"))
    assert [(source.name, source.group) for source in sources] == [
        ("learn9", "boxes"),
        ("learn10", "boxes"),
        ("learn17", "stacked boxes"),
        ("learn44", "cylindric objects"),
        ("more/x", "more"),
        ("other", tmp_path.name),
        ("test65", "complex scenes"),
    ]
    plain = open_dataset(tmp_path)
    assert {source.group for source in plain} == {tmp_path.name, "more"}


def test_finds_rendered_frames_in_subfolders(tmp_path):
    for name in ("a/1", "a/2", "b"):
        folder = tmp_path / name
        folder.mkdir(parents=True)
        for suffix in (".png", ".json", "_colour.png"):
            shutil.copy(SAMPLE / f"depth{suffix}", folder)
        truth = np.zeros(SIZE, np.uint16)
        truth[:10] = 3
        write_png(folder / "true_labels.png", truth)
    sources = open_dataset(tmp_path)
    found = [(source.name, source.group) for source in sources]
    assert found == [("a/1", "a"), ("a/2", "a"), ("b", tmp_path.name)]
    read = sources[0].load()
    assert np.unique(read.truth).tolist() == [0, 3]
    assert 0.3 < np.median(read.frame.depth) < 2.0
    assert [source.name for source in open_dataset(tmp_path / "b")] == ["b"]
    with pytest.raises(InputError, match="npz"):
        open_dataset(tmp_path, DatasetOptions(depth_scale_mm=1.0))
    (tmp_path / "b" / "depth.png").unlink()
    with pytest.raises(InputError, match=r"depth\.png"):
        sources[2].load()


def test_decodes_osd_labels():
    label = np.array([[0, 1, 19, 20, 21, 39, 70]])
    assert decode_labels(label, (1, 7), "osd").tolist() == [[0, 0, 0, 2, 2, 3, 7]]
    assert decode_labels(label, (1, 7), "plain").tolist() == label.tolist()


def test_reads_osd_database(real_data):
    sources = open_dataset(real_data / "mosd_learn", DatasetOptions(labels="osd"))
    assert len(sources) == 45
    read = sources[0].load()
    assert (read.truth.max(), read.assumed) == (3, ())
    assert 0.5 < np.median(read.frame.depth[read.frame.valid]) < 1.5
