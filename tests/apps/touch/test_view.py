"""`eyehand touch view`: pictures, the page, recordings, and wrong sources."""

import json
import os
import pty
import threading
import time
import urllib.request

import numpy as np
import pytest

from eyehand.apps.fitting.page_server import ANY_PORT
from eyehand.apps.touch import view
from eyehand.apps.touch.touch_page import MESSAGE_SECONDS, TouchPage, touch_picture
from eyehand.apps.touch.view import touch_view
from eyehand.apps.touch.view_sources import counts_calibration, open_source
from eyehand.errors import DeviceError, InputError
from eyehand.tactile import TactileArray, TactileImage, contact_features
from eyehand.tactile.sensors import ContactSensor, RecordedSensor, SensorInfo, TactileFrame, record

from ...tactile.sensors.firmware import encode_serial


def test_picture_has_brightest_tactel_at_its_place_and_marks_the_centre():
    array = TactileArray.flat(4, 6)
    pressures = np.zeros(24)
    pressures[6 * 3 + 1] = 900.0  # last row: the upper edge of the picture, second column
    image = TactileImage(pressures, array)
    bare = touch_picture(image, contact_features(TactileImage(np.zeros(24), array), 1.0), 900.0)
    assert bare.shape == (320, 480, 3)
    brightest = np.argwhere(bare.sum(axis=2) == bare.sum(axis=2).max())
    assert brightest.min(axis=0).tolist() == [0, 80]
    assert brightest.max(axis=0).tolist() == [79, 159]
    marked = touch_picture(image, contact_features(image, 10.0), 900.0, np.array([1.0, 0.0]))
    changed = np.argwhere((marked != bare).any(axis=2))
    assert abs(changed.mean(axis=0)[0] - 40) < 3
    assert changed[:, 1].max() > 160


def test_picture_of_a_list_of_tactels_shows_each():
    tip = TactileArray.fingertip()
    dark = touch_picture(
        TactileImage(np.zeros(12), tip), contact_features(TactileImage(np.zeros(12), tip), 1.0), 1.0
    )
    assert (dark == 255).all(axis=2).any()
    assert (dark.sum(axis=2) < 400).mean() > 0.5


def test_page_serves_features_and_faults(capfd):
    sensor, calibration = open_source("real", 0)
    assert calibration is not None
    contact = ContactSensor(sensor, calibration)
    readings = [contact.read(0.004) for _ in range(190)]
    with TouchPage(contact, "Pa", ANY_PORT) as page:
        with urllib.request.urlopen(page.address, timeout=5) as answer:
            assert answer.status == 200
        page.show(readings[-1])
        assert f"{readings[-1].features.force:.2f} N" in page.text.content
        assert "side force" in page.text.content
    assert capfd.readouterr().out == ""


def test_simulated_sensor_is_recorded_with_calibration_and_played(tmp_path, capsys):
    path = tmp_path / "new" / "touch.mcap"
    assert touch_view("good", out=path, seconds=1.0, port=ANY_PORT, json=True) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert row["images"] == 251
    assert row["max_force_n"] > 1.0
    assert (row["faults"], row["calibrated"]) == ([], True)
    assert RecordedSensor(path).calibration is not None
    assert touch_view(str(path), seconds=0.9, port=ANY_PORT, json=True) == 0
    (played,) = json.loads(capsys.readouterr().out)["rows"]
    assert 0.9 * row["max_force_n"] < played["max_force_n"] <= row["max_force_n"]


def test_failed_zeroing_is_shown_and_the_recording_goes_on(tmp_path, monkeypatch):
    path, pages = tmp_path / "a.mcap", []
    sensor, calibration = open_source("good", 0)
    record(sensor, path, 0.1, calibration)

    class Pressed(TouchPage):
        def __enter__(self) -> TouchPage:
            pages.append(self)
            self.show = lambda reading: setattr(self, "zero_wanted", reading.frame is None)
            return self

    monkeypatch.setattr(view, "TouchPage", Pressed)
    assert touch_view(str(path), out=tmp_path / "b.mcap", seconds=0.5, port=ANY_PORT) == 0
    assert "not zeroed:** simulated pad, good returned 0 of 50" in pages[0].text.content
    assert len(list(iter(RecordedSensor(tmp_path / "b.mcap").read, None))) > 20


def test_message_stays_for_a_while(monkeypatch):
    sensor, calibration = open_source("good", 0)
    assert calibration is not None
    contact = ContactSensor(sensor, calibration)
    now = [100.0]
    monkeypatch.setattr("eyehand.apps.touch.touch_page.time.monotonic", lambda: now[0])
    with TouchPage(contact, "Pa", ANY_PORT) as page:
        page.say("**not zeroed**")
        now[0] += 1.0
        page.show(contact.read(0.004))
        assert page.text.content == "**not zeroed**"
        now[0] += MESSAGE_SECONDS
        page.show(contact.read(0.004))
        assert "brightest colour" in page.text.content


def test_serial_sensor_without_calibration_is_shown_in_counts(capsys):
    master, slave = pty.openpty()
    running = True

    def firmware() -> None:
        rng, start = np.random.default_rng(0), time.monotonic()
        while running:
            passed = time.monotonic() - start
            raw = rng.normal(100.0, 2.0, (4, 6))
            raw[1:3, 1:3] += 500.0 if passed > 1.5 else 0.0
            frame = TactileFrame(passed, raw.ravel().astype(np.uint16), np.ones((24, 2)))
            os.write(master, encode_serial(frame, (4, 6)))
            time.sleep(0.01)

    thread = threading.Thread(target=firmware)
    thread.start()
    try:
        assert touch_view(f"shear:{os.ttyname(slave)}", seconds=2.0, port=ANY_PORT, json=True) == 0
    finally:
        running = False
        thread.join()
        os.close(master)
        os.close(slave)
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert (row["calibrated"], row["faults"]) == (False, [])
    assert row["max_force_n"] == pytest.approx(4 * 500 * 0.0047**2, rel=0.1)


def test_wrong_sources_are_refused(tmp_path):
    with pytest.raises(InputError, match="simulated sensor"):
        open_source("camera", 0)
    with pytest.raises(InputError, match="No such file"):
        open_source("none.mcap", 0)
    with pytest.raises(DeviceError, match="cannot open"):
        open_source("serial:/dev/none", 0)
    with pytest.raises(InputError, match="seconds"):
        touch_view("good", seconds=0.0)
    with pytest.raises(InputError, match="itself"):
        touch_view(str(tmp_path / "a.mcap"), out=tmp_path / "a.mcap")


def test_counts_calibration_needs_images():
    sensor, _ = open_source("good", 0)

    class Silent:
        info = sensor.info
        waits = 0

        def read(self, timeout: float = 1.0) -> None:
            """Return nothing."""
            self.waits += 1

        def close(self) -> None:
            """Do nothing."""

    silent = Silent()
    with pytest.raises(InputError, match="0 of 50 images"):
        counts_calibration(silent)
    assert silent.waits == 1


def test_side_force_is_drawn_only_with_a_calibration(monkeypatch):
    sensor, calibration = open_source("real", 0)
    assert calibration is not None
    contact = ContactSensor(sensor, calibration)
    reading = [contact.read(0.004) for _ in range(190)][-1]
    assert reading.side_force is not None
    drawn = []

    def picture(image, features, full, side_force):
        drawn.append(side_force)
        return touch_picture(image, features, full, side_force)

    monkeypatch.setattr("eyehand.apps.touch.touch_page.touch_picture", picture)
    for unit in ("Pa", "counts"):
        with TouchPage(contact, unit, ANY_PORT) as page:
            page.show(reading)
    assert drawn[0] is reading.side_force
    assert drawn[1] is None


OWN = """
import numpy as np
from eyehand.tactile import TactileArray
from eyehand.tactile.sensors import SensorInfo, TactileFrame

class Mine:
    info = SensorInfo("my array", TactileArray.flat(2, 3, 0.005), 250.0)
    images = 0

    def read(self, timeout=1.0):
        self.images += 1
        return TactileFrame(self.images / 250.0, np.arange(100, 106, dtype=np.uint16))

    def close(self):
        pass

class Empty:
    pass

class Greedy(Mine):
    def __init__(self, port):
        pass
"""


def test_recording_without_calibration_is_played_like_the_sensor(tmp_path, monkeypatch):
    class Pressed:
        info = SensorInfo("pad", TactileArray.flat(4, 6), 1000.0)
        count = 0

        def read(self, timeout=1.0):
            self.count += 1
            raw = np.full(24, 200 + self.count % 3, np.uint16)
            raw[[8, 9, 14, 15]] += 500 * (self.count > 60)
            return TactileFrame(self.count / 1000.0, raw)

        def close(self):
            pass

    path = tmp_path / "pressed.mcap"
    monkeypatch.setattr(view, "open_source", lambda *_: (Pressed(), None))
    touch_view("own", seconds=0.1, out=path, port=ANY_PORT)

    sensor, known = open_source(str(path), 0)
    contact = ContactSensor(sensor, known or counts_calibration(sensor))
    forces = [contact.read(0.001).features.force for _ in range(60)]
    assert forces[5] == 0.0
    assert forces[-1] > 0.0


def test_own_sensor_class_is_a_source(tmp_path, monkeypatch):
    (tmp_path / "my_array.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    sensor, calibration = open_source("my_array:Mine", 0)
    assert sensor.info.name == "my array"
    assert calibration is None
    for source, message in (
        ("my_array:Empty", "must have info, read and close"),
        ("my_array:Greedy", "must need no arguments"),
        ("my_array:Missing", "cannot import the sensor"),
        ("no_such_module:Mine", "cannot import the sensor"),
    ):
        with pytest.raises(InputError, match=message):
            open_source(source, 0)
