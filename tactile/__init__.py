"""Touch: tactile images, the features of a contact, and the servo that acts on them."""

from .cable import CableFollower, CableOptions, LineFit, course
from .calibration import Calibration, calibrate, calibrate_linear
from .calibration_curves import BenchRun
from .calibration_file import load_calibration, save_calibration
from .contour_follower import ContourFollower, ContourPoint, ContourStep
from .contour_options import ContourOptions
from .feature_reader import FeatureReader
from .features import ContactFeatures, FeatureOptions, contact_features
from .filters import FeatureFilter, MovingAngle, MovingAverage
from .hough import HoughOptions, hough_axis
from .image import TactileArray, TactileImage
from .phase_options import PhaseOptions
from .phases import Outcome, PhaseStep, TouchPhases
from .selection import PRESETS, SelectionMatrix
from .servo import SensorTwist, ServoGoal, TactileServo
from .servo_options import ServoOptions
from .stiffness import StiffnessEstimate
from .twist import adjoint, world_twist

__all__ = [
    "PRESETS",
    "BenchRun",
    "CableFollower",
    "CableOptions",
    "Calibration",
    "ContactFeatures",
    "ContourFollower",
    "ContourOptions",
    "ContourPoint",
    "ContourStep",
    "FeatureFilter",
    "FeatureOptions",
    "FeatureReader",
    "HoughOptions",
    "LineFit",
    "MovingAngle",
    "MovingAverage",
    "Outcome",
    "PhaseOptions",
    "PhaseStep",
    "SelectionMatrix",
    "SensorTwist",
    "ServoGoal",
    "ServoOptions",
    "StiffnessEstimate",
    "TactileArray",
    "TactileImage",
    "TactileServo",
    "TouchPhases",
    "adjoint",
    "calibrate",
    "calibrate_linear",
    "contact_features",
    "course",
    "hough_axis",
    "load_calibration",
    "save_calibration",
    "world_twist",
]
