"""Compute the twist of a tactile pad from recorded readings, cycle by cycle."""

import numpy as np

from eyehand.tactile import (
    PRESETS,
    ServoGoal,
    TactileArray,
    TactileImage,
    TactileServo,
    contact_features,
)

PERIOD, THRESHOLD = 0.004, 200.0  # s between readings, Pa


def recording(array, cycles=200):
    """Return pressures (cycles, N), Pa: a contact that starts 8 mm from the middle of the pad."""
    shift = 0.008 * np.exp(-np.arange(cycles) / 60.0)
    gaps = np.hypot(array.positions[:, 0] - shift[:, None], array.positions[:, 1])
    return 4000.0 * np.exp(-0.5 * (gaps / 0.006) ** 2)


def main():
    array = TactileArray.flat()  # 16 x 16 tactels, 5 mm apart
    servo = TactileServo(ServoGoal(pressure=2000.0), PRESETS["track"])
    for number, pressures in enumerate(recording(array)):
        features = contact_features(TactileImage(pressures, array), THRESHOLD)
        twist = servo.step(features, PERIOD)
        if number % 50 == 0:
            x = 1000 * features.centre[0]
            print(f"centre {x:.1f} mm, slide {1000 * twist.twist[0]:.1f} mm/s")


if __name__ == "__main__":
    main()
