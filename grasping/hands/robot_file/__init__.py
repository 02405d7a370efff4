"""Describe grippers from the files of robots: MJCF and URDF."""

from .describe import DescribedHand, FileChoices, describe_hand
from .jaw_postures import JawPostures
from .read_model import load_description

__all__ = ["DescribedHand", "FileChoices", "JawPostures", "describe_hand", "load_description"]
