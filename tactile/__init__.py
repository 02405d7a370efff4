"""Touch: tactile images and the features of a contact."""

from .calibration import Calibration, calibrate, calibrate_linear
from .calibration_curves import BenchRun
from .calibration_file import load_calibration, save_calibration
from .feature_reader import FeatureReader
from .features import ContactFeatures, FeatureOptions, contact_features
from .filters import FeatureFilter, MovingAngle, MovingAverage
from .hough import HoughOptions, hough_axis
from .image import TactileArray, TactileImage

__all__ = [
    "BenchRun",
    "Calibration",
    "ContactFeatures",
    "FeatureFilter",
    "FeatureOptions",
    "FeatureReader",
    "HoughOptions",
    "MovingAngle",
    "MovingAverage",
    "TactileArray",
    "TactileImage",
    "calibrate",
    "calibrate_linear",
    "contact_features",
    "hough_axis",
    "load_calibration",
    "save_calibration",
]
