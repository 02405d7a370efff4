"""Recordings of tactile sensors: contents, playback, and damaged files."""

import numpy as np
import pytest

from eyehand.errors import DeviceError, InputError
from eyehand.tactile import BenchRun, TactileArray, calibrate
from eyehand.tactile.sensors import (
    RecordedSensor,
    SensorInfo,
    TactileFrame,
    TactileRecorder,
    TactileSensor,
    record,
)

FLAT = SensorInfo("flat", TactileArray.flat(4, 6, 0.0047), 100.0, 16, shear=True)
TIP = SensorInfo("tip", TactileArray.fingertip(), 250.0)


def frames(info: SensorInfo, count: int = 30) -> list[TactileFrame]:
    rng, tactels = np.random.default_rng(0), len(info.array.positions)
    return [
        TactileFrame(
            1.0 + k / info.rate,
            rng.integers(0, 2**info.bits, tactels).astype(np.uint16),
            rng.normal(0, 500.0, (tactels, 2)) if info.shear else None,
        )
        for k in range(count)
    ]


class ListSensor:
    """A sensor that returns prepared images."""

    def __init__(self, info: SensorInfo, images: list[TactileFrame]) -> None:
        self.info, self._images = info, iter(images)

    def read(self, timeout: float = 1.0) -> TactileFrame | None:
        """Return the next image."""
        return next(self._images, None)

    def close(self) -> None:
        """Do nothing."""


def bench(tactels: int) -> BenchRun:
    loads = np.linspace(0.0, 5000.0, 60)
    return BenchRun(loads, np.rint(100 + 0.5 * loads[:, None] * np.ones(tactels)).astype(np.uint16))


def test_record_refuses_times_in_ms(tmp_path):
    images = [TactileFrame(1000 * image.time, image.raw, image.shear) for image in frames(FLAT)]
    with pytest.raises(InputError, match="times must be in s"):
        record(ListSensor(FLAT, images), tmp_path / "touch.mcap", 0.5)


@pytest.mark.parametrize("info", [FLAT, TIP], ids=lambda info: info.name)
def test_recording_plays_what_was_recorded(info, tmp_path):
    images, path = frames(info), tmp_path / "touch.mcap"
    calibration = calibrate(bench(len(info.array.positions)))
    assert record(ListSensor(info, images), path, 1e3, calibration) == len(images)
    assert [child.name for child in tmp_path.iterdir()] == ["touch.mcap"]
    played: TactileSensor = RecordedSensor(path)
    for name in ("positions", "normals", "areas", "neighbours", "links", "geometry"):
        assert np.array_equal(getattr(played.info.array, name), getattr(info.array, name))
    for name in ("name", "rate", "bits", "shear"):
        assert getattr(played.info, name) == getattr(info, name)
    assert played.info.array.grid == info.array.grid
    for image in images:
        found = played.read()
        assert found is not None
        assert found.time == image.time
        assert np.array_equal(found.raw, image.raw)
        assert (found.shear is None) == (image.shear is None)
        if image.shear is not None and found.shear is not None:
            assert np.allclose(found.shear, image.shear, rtol=1e-6)
    assert played.read() is None
    attached = RecordedSensor(path).calibration
    assert attached is not None
    assert np.array_equal(attached.curves, calibration.curves)


def test_record_stops_after_its_time_by_the_clock_of_the_sensor(tmp_path):
    assert record(ListSensor(TIP, frames(TIP, 100)), tmp_path / "a.mcap", 0.1) == 25
    assert RecordedSensor(tmp_path / "a.mcap").calibration is None


def test_other_tools_read_the_recording_as_ros_2_messages(tmp_path):
    from mcap.reader import make_reader

    image = frames(FLAT, 1)[0]
    with TactileRecorder(tmp_path / "a.mcap", FLAT) as recorder:
        recorder.write(image)
    with (tmp_path / "a.mcap").open("rb") as file:
        (schema, channel, message), *_ = make_reader(file).iter_messages("/tactile/frames")
    assert schema is not None
    assert (schema.name, schema.encoding) == ("eyehand_msgs/msg/TactileFrame", "ros2msg")
    assert (channel.message_encoding, message.log_time) == ("cdr", 1_000_000_000)
    assert "uint16[] raw" in schema.data.decode()
    # CDR: a header of 4 bytes, the time of 8, the count of 4, then the readings.
    assert message.data[:4] == b"\x00\x01\x00\x00"
    assert np.frombuffer(message.data[4:12], "<f8")[0] == image.time
    assert np.array_equal(np.frombuffer(message.data[16:64], "<u2"), image.raw)


def test_playback_in_real_time_keeps_the_time_between_images(tmp_path):
    images = frames(TIP, 4)
    record(ListSensor(TIP, images), tmp_path / "a.mcap", 1.0)
    player = RecordedSensor(tmp_path / "a.mcap", speed=0.1)
    assert player.read() is not None
    # The next image is 40 ms away at a tenth of the speed.
    assert player.read(0.001) is None
    assert player.read(1.0) is not None


def test_recording_is_kept_if_the_sensor_is_lost_but_not_if_writing_fails(tmp_path, monkeypatch):
    class Unplugged(ListSensor):
        def read(self, timeout: float = 1.0) -> TactileFrame:
            """Return the next image; after the last one the device is gone."""
            frame = super().read(timeout)
            if frame is None:
                raise DeviceError("unplugged")
            return frame

    with pytest.raises(DeviceError, match="unplugged"):
        record(Unplugged(TIP, frames(TIP, 7)), tmp_path / "a.mcap", 1e3)
    assert len(list(iter(RecordedSensor(tmp_path / "a.mcap").read, None))) == 7

    def full(*message: object) -> None:
        raise OSError(28, "No space left on device")

    recorder, image = TactileRecorder(tmp_path / "b.mcap", TIP), frames(TIP, 1)[0]
    monkeypatch.setattr(recorder._writer, "add_message", full)
    with pytest.raises(DeviceError, match="No space left"), recorder:
        recorder.write(image)
    assert [child.name for child in tmp_path.iterdir()] == ["a.mcap"]


def test_changed_recordings_are_refused_or_play_unchanged(tmp_path):
    images, path = frames(FLAT), tmp_path / "a.mcap"
    record(ListSensor(FLAT, images), path, 1e3, calibrate(bench(24)))
    whole, rng, refused = path.read_bytes(), np.random.default_rng(0), 0
    for kind in range(300):
        data, place = bytearray(whole), int(rng.integers(len(whole) - 8))
        if kind % 3 == 0:
            data[place] ^= 1 << int(rng.integers(8))
        elif kind % 3 == 1:
            data[place : place + 8] = b"\xff" * 8
        else:
            del data[place : place + int(rng.integers(1, 40))]
        path.write_bytes(data)
        try:
            sensor = RecordedSensor(path)
            found = list(iter(sensor.read, None))
            assert sensor.calibration is not None or b"calibration.npz" not in data
        except InputError:
            refused += 1
        else:
            assert all(np.array_equal(a.raw, b.raw) for a, b in zip(found, images, strict=False))
    assert refused > 200


@pytest.mark.parametrize("cut", [8, 200, 1000, 2000])
def test_damaged_recordings_are_refused_with_their_name(cut, tmp_path):
    path = tmp_path / "touch.mcap"
    record(ListSensor(FLAT, frames(FLAT)), path, 1e3)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) - cut])
    with pytest.raises(InputError, match=r"touch\.mcap"):
        list(iter(RecordedSensor(path).read, None))


def test_other_files_are_refused(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        RecordedSensor(tmp_path / "none.mcap")
    (tmp_path / "text.mcap").write_text("hello")
    with pytest.raises(InputError, match=r"text\.mcap is not a tactile recording"):
        RecordedSensor(tmp_path / "text.mcap")
    record(ListSensor(FLAT, []), tmp_path / "empty.mcap", 1.0, calibrate(bench(24)))
    with pytest.raises(InputError, match=r"empty\.mcap has no images"):
        RecordedSensor(tmp_path / "empty.mcap")
    with pytest.raises(InputError, match=r"\.mcap file"):
        TactileRecorder(tmp_path / "touch.bag", FLAT)
    with pytest.raises(InputError, match="does not exist"):
        TactileRecorder(tmp_path / "none" / "touch.mcap", FLAT)


def test_wrong_images_are_refused_and_the_right_ones_kept(tmp_path):
    images = frames(FLAT, 2)
    for wrong in (
        TactileFrame(0.0, images[0].raw),
        TactileFrame(0.0, images[0].raw[:5], images[0].shear),
        TactileFrame(float("nan"), images[0].raw, images[0].shear),
        TactileFrame(-1.0, images[0].raw, images[0].shear),
    ):
        with TactileRecorder(tmp_path / "a.mcap", FLAT) as recorder:
            recorder.write(images[0])
            with pytest.raises(InputError, match=r"flat|time of an image"):
                recorder.write(wrong)
        assert RecordedSensor(tmp_path / "a.mcap").read() is not None
