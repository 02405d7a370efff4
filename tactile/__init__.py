"""Tactile sensing and control: tactile images, contact features, and the servo that uses them.

A :class:`FeatureReader` converts raw readings to :class:`ContactFeatures`. A :class:`TactileServo`
converts features to a twist of the sensor. :class:`TouchPhases` moves the pad to the contact,
supervises the servo, and backs off. :class:`CableFollower` and :class:`ContourFollower` compute an
external twist along the surface, which the servo adds. :func:`calibrate` computes the
:class:`Calibration` of a pad from a :class:`BenchRun`. :func:`save_calibration` and
:func:`load_calibration` write and read it. :func:`flat_press_gains` measures how the gains have
changed since.

Equation and section numbers refer to Haschke's chapter.
"""

from eyehand.errors import describe_fields

from .cable import CableFollower, CableOptions
from .calibration import Calibration, calibrate, calibrate_linear
from .calibration_curves import BenchRun
from .calibration_file import load_calibration, save_calibration
from .contour_follower import ContourFollower
from .contour_progress import ContourOptions
from .contour_step import ContourPoint
from .feature_reader import FeatureReader
from .features import ContactFeatures, FeatureOptions, contact_features, contact_region
from .flat_press import flat_press_gains
from .friction_pull import FrictionPull
from .glove import Glove, HandFeatures
from .grip_laws import GripLaw, GripReading, LoadGrip, LoadGripOptions, SlipGrip
from .hough import HoughOptions, hough_axis
from .image import TactileArray, TactileImage, tangents
from .load_memory import FoamMemory, MemoryFilter, fit_creep, fit_memory
from .moments import long_axis
from .phase_options import PhaseOptions
from .phase_step import PhaseStep
from .phases import TouchPhases
from .press_decoder import PressDecoder, fit_decoder
from .selection import PRESETS, SelectionMatrix
from .servo import ServoGoal, TactileServo
from .servo_options import ServoOptions
from .slip_detector import SlipDetector, SlipScore, with_past
from .slip_features import PRESSURE_FEATURES, SlipState
from .timing import Timing, identify_timing
from .twist import world_twist

__all__ = [
    "PRESETS",
    "PRESSURE_FEATURES",
    "BenchRun",
    "CableFollower",
    "CableOptions",
    "Calibration",
    "ContactFeatures",
    "ContourFollower",
    "ContourOptions",
    "ContourPoint",
    "FeatureOptions",
    "FeatureReader",
    "FoamMemory",
    "FrictionPull",
    "Glove",
    "GripLaw",
    "GripReading",
    "HandFeatures",
    "HoughOptions",
    "LoadGrip",
    "LoadGripOptions",
    "MemoryFilter",
    "PhaseOptions",
    "PhaseStep",
    "PressDecoder",
    "SelectionMatrix",
    "ServoGoal",
    "ServoOptions",
    "SlipDetector",
    "SlipGrip",
    "SlipScore",
    "SlipState",
    "TactileArray",
    "TactileImage",
    "TactileServo",
    "Timing",
    "TouchPhases",
    "calibrate",
    "calibrate_linear",
    "contact_features",
    "contact_region",
    "fit_creep",
    "fit_decoder",
    "fit_memory",
    "flat_press_gains",
    "hough_axis",
    "identify_timing",
    "load_calibration",
    "long_axis",
    "save_calibration",
    "tangents",
    "with_past",
    "world_twist",
]

describe_fields(*map(globals().get, __all__))
