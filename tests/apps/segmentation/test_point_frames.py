"""Annotated points: verdicts by hand, reading of files, and the command."""

import json

import cv2
import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.segmentation import point_frames
from eyehand.apps.segmentation.point_frames import PointFrame, read_point_frames, score_points
from eyehand.data_synth import DepthNoise, make_scene, render_frame
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.io import write_intrinsics, write_png

CAMERA = CameraIntrinsics(50.0, 50.0, 10.0, 5.0, 20, 10)
FRAME = DepthFrame(np.ones((10, 20), np.float32), CAMERA)


def annotated(objects, background=(), ignored=None):
    """Return a frame whose objects have points in the first row, given by their columns."""
    points = {name: np.array([[u, 0] for u in columns]) for name, columns in objects.items()}
    behind = np.array([[u, 0] for u in background]).reshape(-1, 2)
    mask = np.zeros((10, 20), bool) if ignored is None else ignored
    return PointFrame("frame", FRAME, None, points, behind, mask)


def labels_of(row):
    labels = np.zeros((10, 20), np.int32)
    labels[0, : len(row)] = row
    return labels


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        ([1, 1, 2, 0], "right"),
        ([0, 0, 2, 0], "missed"),
        ([1, 3, 2, 0], "split"),
        ([1, 0, 2, 0], "split"),
        ([1, 1, 1, 0], "merged"),
        ([1, 1, 2, 1], "on_background"),
    ],
)
def test_verdicts(row, verdict):
    truth = annotated({"cup": [0, 1], "box": [2]}, background=[3])
    assert score_points(labels_of(row), truth).verdicts["cup"] == verdict


@pytest.mark.parametrize(
    ("named", "unsaid", "false_alarms"), [((), 3, 0), ({1}, 3, 1), ({2}, 1, 0), ({2, 3}, 1, 0)]
)
def test_warnings_are_compared_with_the_verdicts(named, unsaid, false_alarms):
    truth = annotated({"cup": [0, 1], "box": [2], "tin": [3], "pen": [4]}, [9])
    score = score_points(labels_of([1, 1, 2, 2, 0]), truth, named)
    assert (score.unsaid, score.false_alarms) == (unsaid, false_alarms)


def test_surplus_segments_hold_no_point_and_touch_no_ignored_region():
    labels = labels_of([1, 0, 0])
    labels[5, 5], labels[5, 15] = 2, 3
    ignored = np.zeros((10, 20), bool)
    ignored[4:7, 14:17] = True
    assert score_points(labels, annotated({"cup": [0]}, [1], ignored)).surplus == 1


def test_missing_and_damaged_annotations_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"holds no \*/points.json"):
        read_point_frames(tmp_path)
    folder = tmp_path / "one"
    folder.mkdir()
    write_png(folder / "depth.png", np.full((10, 20), 1000, np.uint16))
    write_intrinsics(folder / "camera.json", CAMERA)
    (folder / "points.json").write_text('{"objects": [{"name": "cup"}]}')
    with pytest.raises(InputError, match="no file of annotated points"):
        read_point_frames(tmp_path)


def test_colour_of_another_size_is_refused_from_its_header(tmp_path, monkeypatch):
    folder = tmp_path / "one"
    folder.mkdir()
    write_png(folder / "depth.png", np.full((10, 20), 1000, np.uint16))
    write_intrinsics(folder / "camera.json", CAMERA)
    (folder / "points.json").write_text('{"objects": []}')
    image = cv2.imencode(".jpg", np.zeros((10, 20, 3), np.uint8))[1].tobytes()
    (folder / "colour.jpg").write_bytes(image)
    assert read_point_frames(tmp_path)[0].colour is not None
    # The frame header of a JPEG begins with FF C0 and holds height and width.
    at = image.index(b"\xff\xc0") + 5
    huge = image[:at] + b"\xff\xdc\xff\xdc" + image[at + 4 :]
    decode = cv2.imdecode

    def decode_depth_only(data, flags):
        assert data[:2].tobytes() != image[:2], "the colour image was unpacked"
        return decode(data, flags)

    monkeypatch.setattr(point_frames.cv2, "imdecode", decode_depth_only)
    for data in (huge, b"no image"):
        (folder / "colour.jpg").write_bytes(data)
        with pytest.raises(InputError, match="is no colour image of"):
            read_point_frames(tmp_path)


def write_colour(folder, frame):
    """Write the colour of a frame beside its depth."""
    _, data = cv2.imencode(".jpg", cv2.cvtColor(frame.colour, cv2.COLOR_RGB2BGR))
    (folder / "colour.jpg").write_bytes(data.tobytes())


def test_command_scores_annotated_frames(tmp_path, capsys):
    frame, labels = render_frame(make_scene(5), DepthNoise.realistic(), 5)
    folder = tmp_path / "frames" / "one"
    folder.mkdir(parents=True)
    write_png(folder / "depth.png", np.rint(1000 * frame.depth).astype(np.uint16))
    write_intrinsics(folder / "camera.json", frame.intrinsics)
    write_colour(folder, frame)
    objects = []
    for label in range(1, labels.max() + 1):
        rows, columns = np.nonzero(labels == label)
        middle = len(rows) // 2
        objects.append({"name": "thing", "points": [[int(columns[middle]), int(rows[middle])]]})
    (folder / "points.json").write_text(json.dumps({"objects": objects}))
    words = ["--points", str(folder.parent), "--out", str(tmp_path / "out"), "--json"]
    with pytest.raises(SystemExit) as ended:
        main(["evaluate", "segmentation", *words])
    assert ended.value.code == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    named = [(row["name"], row["input"]) for row in rows]
    inputs = ("depth", "colour")
    assert named == [
        *(("one", used) for used in inputs),
        *((name, used) for used in inputs for name in ("one", "total")),
    ]
    assert rows[0]["right"] == len(objects)
    assert len(objects) - 1 <= rows[0]["right_copies"] <= len(objects)
    assert min(rows[0]["self_agreement_pct"], rows[0]["moved_agreement_pct"]) > 90
