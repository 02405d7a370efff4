"""The simulated tactile pad.

A foam bed presses on objects and feels them (`TactilePad`), an arm carries it (`pad_scene`),
`PadSimulation` advances time, and `run_bench` loads it for calibration.
"""

from .calibration_bench import run_bench
from .foam import Foam, PadOptions
from .held_object import HeldObject, HeldSimulation
from .pad_scene import Arm, PadScene, PlacedObject, pad_scene, padded_arm
from .pad_simulation import CONTROL_RATE, PadSample, PadSimulation
from .sensor_model import SENSORS, SensorModel
from .simulated_sensor import SimulatedSensor
from .tactile_pad import IMAGE_RATE, PAD_SITE, TactilePad
from .tactile_readout import TactileReadout
from .touch_objects import (
    Part,
    TouchObject,
    box_edge,
    cable,
    pen,
    probe,
    soft_ball,
    tilted_face,
    toy_box,
    unknown_object,
)
from .touch_surface import surface_distance, top_surface

__all__ = [
    "CONTROL_RATE",
    "IMAGE_RATE",
    "PAD_SITE",
    "SENSORS",
    "Arm",
    "Foam",
    "HeldObject",
    "HeldSimulation",
    "PadOptions",
    "PadSample",
    "PadScene",
    "PadSimulation",
    "Part",
    "PlacedObject",
    "SensorModel",
    "SimulatedSensor",
    "TactilePad",
    "TactileReadout",
    "TouchObject",
    "box_edge",
    "cable",
    "pad_scene",
    "padded_arm",
    "pen",
    "probe",
    "run_bench",
    "soft_ball",
    "surface_distance",
    "tilted_face",
    "top_surface",
    "toy_box",
    "unknown_object",
]
