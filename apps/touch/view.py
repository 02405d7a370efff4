"""`eyehand touch view`: show a tactile sensor or a recording live in the browser."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path

from eyehand.errors import DeviceError, InputError
from eyehand.tactile import load_calibration
from eyehand.tactile.sensors import ContactSensor, TactileRecorder

from ..console import print_json, say
from ..output_files import make_folder
from .touch_page import TouchPage
from .view_sources import counts_calibration, open_source

DEFAULT_PORT = 8080
"""Port of the page unless it is taken."""


def touch_view(
    source: str,
    *,
    calibration: Path | None = None,
    out: Path | None = None,
    seconds: float | None = None,
    port: int = DEFAULT_PORT,
    seed: int = 0,
    json: bool = False,
) -> int:
    """Show a tactile sensor or a recording live in the browser, and record it.

    The page has a heat map with the centre, the long axis and the side force of the contact, its
    features, faults of the sensor, and a button that zeroes it. Without a calibration, one count
    above rest is shown as 1, and nothing may touch the sensor at the start. Ctrl-C ends the page.

    Parameters
    ----------
    source
        A recording (FILE.mcap), `serial:PORT` for a 16 x 16 array, `shear:PORT` for a 4 x 6 array
        with shear, `module:Class` for a class of your own without arguments, or a simulated sensor:
        ideal, good, real, harsh.
    calibration
        Calibration of the sensor, a .npz file of `save_calibration`. A recording may contain one.
    out
        Write the images and the calibration to this .mcap file.
    seconds
        End after this time by the clock of the sensor. Without it, the page stays until Ctrl-C.
    port
        Port of the page. If it is taken, the next free port is used.
    seed
        Seed of a simulated sensor.
    json
        Print one JSON object on stdout at the end: images, faults, mean and maximum force.
    """
    if seconds is not None and not seconds > 0:
        raise InputError(f"seconds must be > 0, got {seconds}")
    if out is not None and out.resolve() == Path(source).resolve():
        raise InputError(f"cannot record {source} to itself")
    say("starting; the first run compiles numerical kernels (once, one to two minutes) ...")
    with ExitStack() as stack:
        sensor, known = open_source(source, seed)
        stack.callback(sensor.close)
        known = load_calibration(calibration) if calibration else known
        recorder = None
        if out is not None:
            make_folder(out.parent)
            recorder = stack.enter_context(TactileRecorder(out, sensor.info, known))
        contact = ContactSensor(sensor, known or counts_calibration(sensor, recorder))
        page = stack.enter_context(TouchPage(contact, "Pa" if known else "counts", port))
        say(f"live page at {page.address} - Ctrl-C ends it")
        forces, faults, frames = _run(contact, page, recorder, seconds)
        if recorder is not None:
            say(f"recorded {recorder.frames} images to {out}")
        if json:
            row = {
                "name": sensor.info.name,
                "images": frames,
                "faults": sorted(faults),
                "mean_force_n": sum(forces) / max(len(forces), 1),
                "max_force_n": max(forces, default=0.0),
                "calibrated": known is not None,
            }
            print_json("touch_view", seed, [row])
    return 0


def _run(
    contact: ContactSensor,
    page: TouchPage,
    recorder: TactileRecorder | None,
    seconds: float | None,
) -> tuple[list[float], set[str], int]:
    """Show images until the time is over, or Ctrl-C; return forces, faults and their number."""
    period = 1.0 / contact.sensor.info.rate
    forces, faults, frames = [], set(), 0
    first: float | None = None
    start = time.monotonic()
    try:
        while True:
            reading = contact.read(period)
            if reading.fault:
                faults.add(reading.fault)
            page.show(reading)
            if page.zero_wanted:
                page.zero_wanted = False
                _zero(contact, page)
            if reading.frame is None:
                # A recording that has ended returns at once.
                time.sleep(period)
                passed = time.monotonic() - start
            else:
                frames += 1
                forces.append(reading.features.force)
                if recorder is not None:
                    recorder.write(reading.frame)
                first = reading.frame.time if first is None else first
                passed = reading.frame.time - first
                # Simulations may be faster than real time.
                time.sleep(min(max(start + passed - time.monotonic(), 0.0), 2.0 * period))
            if seconds is not None and passed >= seconds:
                break
    except KeyboardInterrupt:
        pass
    return forces, faults, frames


def _zero(contact: ContactSensor, page: TouchPage) -> None:
    try:
        contact.zero()
    except (InputError, DeviceError, OSError) as error:
        page.say(f"**not zeroed:** {error}")
