"""The frames that the firmware of a serial sensor writes."""

import numpy as np

from eyehand.tactile.sensors import TactileFrame
from eyehand.tactile.sensors.serial_sensor import (
    CLOCK_SPAN,
    CRC,
    HEADER,
    SHEAR_PER_COUNT,
    SYNC,
    crc16,
)


def encode_serial(
    frame: TactileFrame,
    grid: tuple[int, int],
    sequence: int = 0,
    shear_scale: float = SHEAR_PER_COUNT,
) -> bytes:
    """Encode an image of rows and columns as the firmware of a sensor does."""
    values = frame.raw.astype("<u2")[:, None]
    if frame.shear is not None:
        counts = np.clip(np.rint(frame.shear / shear_scale), -(2**15), 2**15 - 1)
        values = np.column_stack([values, counts.astype("<i2").view("<u2")])
    clock = round(1e6 * frame.time) % CLOCK_SPAN
    header = HEADER.pack(SYNC, *grid, values.shape[1], sequence % 256, clock)
    data = header + values.astype("<u2").tobytes()
    return data + CRC.pack(crc16(data))
