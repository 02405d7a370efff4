"""Open what `eyehand touch view` shows: a recording, a sensor on a serial line, or a simulation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.pad import (
    CONTROL_RATE,
    SENSORS,
    PadSimulation,
    SimulatedSensor,
    TactilePad,
    pen,
    run_bench,
    toy_box,
)
from eyehand.errors import InputError
from eyehand.tactile import Calibration, calibrate
from eyehand.tactile.sensors import (
    RecordedSensor,
    TactileRecorder,
    TactileSensor,
    serial_4x6_shear,
    serial_16x16,
)

from ..named_import import import_named
from .stress_world import TACTELS, compiled_world

SERIAL = {"serial": serial_16x16, "shear": serial_4x6_shear}
"""Driver of each prefix of a serial source."""
REST_IMAGES = 50
"""Images at rest from which an uncalibrated sensor gets its zero and noise."""
MIN_COUNTS_NOISE = 0.5
"""Minimum noise of an uncalibrated sensor, counts."""
PRESS, PRESS_SECONDS, CIRCLE, CIRCLE_SECONDS = 0.0012, 3.0, 0.012, 7.0
"""Depth of the simulated press, m, its period, s, and radius, m, and period, s, of its circle."""


def open_source(source: str, seed: int) -> tuple[TactileSensor, Calibration | None]:
    """Open a source by its name, and return the sensor and its calibration, if it has one.

    Raises
    ------
    InputError
        If the name is unknown, the recording cannot be read, or the class is no sensor.
    DeviceError
        If the serial line cannot be opened.
    """
    prefix, _, port = source.partition(":")
    if source in SENSORS:
        return _simulated(source, seed)
    if prefix in SERIAL and port:
        return SERIAL[prefix](port), None
    if Path(source).suffix == ".mcap":
        recording = RecordedSensor(source, speed=1.0)
        return recording, recording.calibration
    if prefix and port:
        return _own(source), None
    raise InputError(
        f"source must be a .mcap file, serial:PORT, shear:PORT, module:Class or a simulated sensor "
        f"({', '.join(SENSORS)}), got {source!r}"
    )


def _own(source: str) -> TactileSensor:
    """Make a sensor of a class that is named as module:Class and needs no arguments."""
    try:
        sensor = import_named(source, "sensor")()
    except TypeError as error:
        raise InputError(f"the sensor {source!r} must need no arguments: {error}") from error
    missing = [name for name in ("info", "read", "close") if not hasattr(sensor, name)]
    if missing:
        raise InputError(f"the sensor {source!r} must have info, read and close, lacks {missing}")
    return sensor


def counts_calibration(
    sensor: TactileSensor, recorder: TactileRecorder | None = None
) -> Calibration:
    """Return a calibration of an untouched sensor by which one count above rest is 1 Pa.

    The recorder gets the images at rest, so that the same ones are used when it is played.

    Raises
    ------
    InputError
        If no images arrive.
    """
    images = []
    # A silent sensor is given up after one timeout.
    while len(images) < REST_IMAGES and (frame := sensor.read()) is not None:
        images.append(frame.raw)
        if recorder is not None:
            recorder.write(frame)
    raws = np.array(images, float)
    if len(raws) < REST_IMAGES:
        raise InputError(
            f"{sensor.info.name} returned {len(raws)} of {REST_IMAGES} images at rest; without a "
            "calibration it must run and be untouched at the start"
        )
    top = 2.0**sensor.info.bits - 1.0
    rest = np.minimum(raws.mean(axis=0), top - 1.0)
    noise = np.maximum(raws.std(axis=0), MIN_COUNTS_NOISE)
    knots = np.column_stack([rest, np.full(len(rest), top)])
    span = np.column_stack([np.zeros(len(rest)), top - rest])
    dead = np.zeros(len(rest), bool)
    return Calibration(knots, span, rest, noise, np.full(len(rest), top), dead, sensor.info.bits)


def _simulated(name: str, seed: int) -> tuple[TactileSensor, Calibration]:
    """Return a simulated pad that a box and a pen touch in turn, and its calibration."""
    model = SENSORS[name]
    compiled, data, softness = compiled_world((toy_box(), pen()))
    # The pad faces down: a half turn about x.
    data.mocap_quat[0] = (0.0, 1.0, 0.0, 0.0)
    readout = model.readout(TACTELS, seed)

    def move(time: float) -> None:
        angle = 2 * np.pi * time / CIRCLE_SECONDS
        # A sine that is negative half of the time: the two objects take turns.
        depth = PRESS * np.sin(2 * np.pi * time / PRESS_SECONDS)
        for number, height in enumerate((depth, -depth), start=1):
            data.mocap_pos[number] = CIRCLE * np.cos(angle), CIRCLE * np.sin(angle), height

    move(0.0)
    import_mujoco().mj_kinematics(compiled, data)
    pad = TactilePad(compiled, data, softness=softness, readout=readout, sensor=model, seed=seed)
    simulation = PadSimulation(compiled, data, (pad,), image_rate=CONTROL_RATE, seed=seed)
    shear = model.shear > 0
    sensor = SimulatedSensor(simulation, name=f"simulated pad, {name}", shear=shear, on_step=move)
    return sensor, calibrate(run_bench(readout, seed=seed))
