"""Serial sensors through a pseudo-terminal: images, damage, resynchronisation, disconnection."""

import contextlib
import os
import pty
import threading

import numpy as np
import pytest

from eyehand.errors import DeviceError, InputError
from eyehand.tactile import TactileArray
from eyehand.tactile.sensors import (
    SensorInfo,
    SerialSensor,
    TactileFrame,
    serial_4x6_shear,
    serial_16x16,
)
from eyehand.tactile.sensors.serial_sensor import crc16

from .firmware import encode_serial


@pytest.fixture
def line():
    """Return the firmware's end of a pseudo-terminal, and the name of the other end."""
    master, slave = pty.openpty()
    yield master, os.ttyname(slave)
    os.close(slave)
    with contextlib.suppress(OSError):
        os.close(master)


def image(k: int, tactels: int = 256, top: int = 4096, *, shear: bool = False) -> TactileFrame:
    rng = np.random.default_rng(k)
    stress = np.rint(rng.normal(0, 900.0, (tactels, 2))) if shear else None
    return TactileFrame(0.01 * k, rng.integers(0, top, tactels).astype(np.uint16), stress)


def test_crc_is_that_of_the_standard():
    assert crc16(b"123456789") == 0x29B1


def test_16x16_images_arrive_unchanged(line):
    master, name = line
    sensor = serial_16x16(name)
    for k in range(5):
        os.write(master, encode_serial(image(k), (16, 16), k))
        found = sensor.read()
        assert found is not None
        assert np.array_equal(found.raw, image(k).raw)
        assert found.time == pytest.approx(0.01 * k)
    assert sensor.read(0.01) is None
    sensor.close()


def test_4x6_images_have_16_bits_and_shear(line):
    master, name = line
    sensor = serial_4x6_shear(name, shear_scale=0.5)
    sent = image(3, 24, 65536, shear=True)
    os.write(master, encode_serial(sent, (4, 6), shear_scale=0.5))
    found = sensor.read()
    assert found is not None
    found.check(sensor.info)
    assert np.array_equal(found.raw, sent.raw)
    assert found.shear is not None
    assert sent.shear is not None
    assert np.array_equal(found.shear, sent.shear)
    sensor.close()


def test_damage_is_skipped_and_newest_image_counts(line):
    master, name = line
    sensor = serial_16x16(name)
    damaged = bytearray(encode_serial(image(1), (16, 16), 1))
    damaged[100] ^= 0x40
    stream = b"\x17\xa5" + damaged + b"\xa5\x5a" + encode_serial(image(2), (16, 16), 2)
    threading.Thread(target=os.write, args=(master, stream + stream[:300])).start()
    found = sensor.read()
    while found is None:
        found = sensor.read()
    assert np.array_equal(found.raw, image(2).raw)
    assert sensor.damaged >= 1
    # The rest of the stream completes the damaged frame; then come two images at once.
    rest = stream[300:] + encode_serial(image(3), (16, 16), 3)
    os.write(master, rest + encode_serial(image(4), (16, 16), 4))
    newest = None
    while newest is None or not np.array_equal(newest.raw, image(4).raw):
        newest = sensor.read(1.0)
        assert newest is not None
    sensor.close()


def test_clock_continues_when_it_overflows(line):
    master, name = line
    sensor = serial_16x16(name)
    times = []
    for seconds in (4294.0, 4294.96, 4294.96 + 0.02):
        frame = TactileFrame(seconds, image(0).raw)
        os.write(master, encode_serial(frame, (16, 16)))
        found = sensor.read()
        assert found is not None
        times.append(found.time)
    assert np.diff(times) == pytest.approx([0.96, 0.02])
    sensor.close()


def test_clock_continues_a_period_later_when_the_sensor_is_reset(line):
    master, name = line
    sensor = serial_16x16(name)
    times = []
    for seconds in (100.0, 100.01, 0.5, 0.51):
        os.write(master, encode_serial(TactileFrame(seconds, image(0).raw), (16, 16)))
        found = sensor.read()
        assert found is not None
        times.append(found.time)
    assert np.diff(times) == pytest.approx([0.01, 1 / 300, 0.01], abs=1e-6)
    sensor.close()


def test_array_that_a_frame_cannot_describe_is_refused(line):
    wide = SensorInfo("wide", TactileArray.flat(2, 256), 10.0)
    with pytest.raises(InputError, match=r"at most 255 rows and columns, got \(2, 256\)"):
        SerialSensor(line[1], wide)
    scattered = SensorInfo("tip", TactileArray.fingertip(), 10.0)
    with pytest.raises(InputError, match="needs a grid"):
        SerialSensor(line[1], scattered)


def test_other_layout_and_disconnection_are_errors(line):
    master, name = line
    sensor = serial_16x16(name)
    os.write(master, encode_serial(image(0, 24), (4, 6)) * 8)
    with pytest.raises(InputError, match="sends 4 x 6 tactels"):
        sensor.read()
    sensor.close()
    sensor = serial_16x16(name)
    os.close(master)
    with pytest.raises(DeviceError, match="disconnected"):
        sensor.read()
    sensor.close()
    with pytest.raises(DeviceError, match="No such file"):
        serial_16x16("/dev/none")
    with pytest.raises(DeviceError, match="not a serial line"):
        serial_16x16("/dev/null")
