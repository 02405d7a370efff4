"""Touch: tactile images and the features of a contact."""

from .features import ContactFeatures, contact_features
from .image import TactileArray, TactileImage

__all__ = ["ContactFeatures", "TactileArray", "TactileImage", "contact_features"]
