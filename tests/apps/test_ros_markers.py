"""`eyehand perceive` reads ROS 2 recordings and writes scenes that Foxglove shows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.perception import perceive, read_frame
from eyehand.perception.cameras import write_ros_frames

pytest.importorskip("mcap_ros2", reason="recordings of ROS 2 need the extra [ros]")

SAMPLE = Path(__file__).resolve().parents[2] / "apps" / "sample" / "depth.png"


def run(*arguments: object, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    with pytest.raises(SystemExit) as exit_info:
        main([str(argument) for argument in arguments])
    return int(exit_info.value.code or 0), capsys.readouterr().err


def messages(path: Path) -> dict[str, list[Any]]:
    """Return the decoded messages of a recording by topic."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    found: dict[str, list[Any]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    return found


@pytest.fixture
def bag(tmp_path) -> Path:
    frame = read_frame(SAMPLE)
    write_ros_frames(tmp_path / "bag.mcap", [frame, frame])
    return tmp_path / "bag.mcap"


def test_recording_is_perceived_and_its_scene_written(bag, tmp_path, capsys):
    out, scene = tmp_path / "out", tmp_path / "new" / "scene.mcap"
    arguments = ("--topic", "/camera/depth", "--frames", 1, "--out", out, "--mcap", scene)
    code, err = run("perceive", bag, *arguments, capsys=capsys)
    assert code == 0, err
    assert (out / "0000" / "scene.json").is_file()
    found = messages(scene)
    (markers,) = found["/eyehand/scene"]
    clear, *drawn = markers.markers
    assert clear.action == 3
    solids = [one for one in drawn if one.type == 11]
    labels = [one.text for one in drawn if one.type == 9]
    # Colour comes back too: without it two objects are one.
    assert len(labels) == len(perceive(read_frame(SAMPLE)).objects) == 6
    assert "3 box" in labels
    assert len(solids) >= 4
    for one in solids:
        corners = np.array([[corner.x, corner.y, corner.z] for corner in one.points])
        assert len(corners) % 3 == 0
        # Objects of the sample are 40 to 120 mm large.
        assert 0.03 < np.ptp(corners, axis=0).max() < 0.2
    assert len(found["/eyehand/grasps"][0].poses) >= 4
    (image,) = found["/camera/depth"]
    depth = np.frombuffer(image.data, "<f4").reshape(image.height, image.width)
    np.testing.assert_array_equal(depth, read_frame(SAMPLE).depth)


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        ((SAMPLE, "--topic", "/a"), "--topic needs a recording (.mcap)"),
        ((SAMPLE, "--mcap", "a.bag"), "--mcap must name an .mcap file, got a.bag"),
        (("bag.mcap", "--topic", "/a"), "topic /a is not in the recording"),
        (("half.mcap",), "truncated"),
        (("bag.mcap", "--mcap", "bag.mcap"), "--mcap must name another file than the recording"),
    ],
)
def test_unusable_recording_is_named_in_one_line(bag, arguments, fault, monkeypatch, capsys):
    monkeypatch.chdir(bag.parent)
    Path("half.mcap").write_bytes(bag.read_bytes()[:5000])
    before = sorted(Path().iterdir())
    code, err = run("perceive", *arguments, "--out", "out", capsys=capsys)
    assert code == 2
    assert fault in err
    assert len(err.strip().splitlines()) == 1
    assert sorted(Path().iterdir()) == before
