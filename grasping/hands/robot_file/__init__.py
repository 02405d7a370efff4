"""Describe grippers from the files of robots: MJCF and URDF."""

from .describe import DescribedHand, FileChoices, describe_hand

__all__ = ["DescribedHand", "FileChoices", "describe_hand"]
