"""Tactile gloves: patches on the links of a hand that share one clock."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .feature_reader import FeatureReader
from .image import TactileArray

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from .calibration import Calibration
    from .features import ContactFeatures, FeatureOptions


class Glove:
    """The patches of a glove. An image is one list of readings, patch after patch.

    Parameters
    ----------
    patches
        Array of each patch by its name, in the patch's own frame.

    Raises
    ------
    InputError
        If there is no patch.
    """

    def __init__(self, patches: Mapping[str, TactileArray]) -> None:
        if not patches:
            raise InputError("a glove needs at least one patch")
        self.patches = dict(patches)
        counts = [len(array.positions) for array in self.patches.values()]
        ends = np.cumsum(counts).tolist()
        self.slices = {
            name: slice(end - count, end)
            for name, count, end in zip(self.patches, counts, ends, strict=True)
        }
        """Readings of each patch in an image."""
        arrays = list(self.patches.values())
        areas = np.concatenate([array.areas for array in arrays])
        self.array = TactileArray(
            np.concatenate([array.positions for array in arrays]),
            np.concatenate([array.normals for array in arrays]),
            float(areas.mean()),
            np.concatenate(
                [a.neighbours + end - n for a, n, end in zip(arrays, counts, ends, strict=True)]
            ).astype(np.int32),
            areas,
        )
        """All tactels as one list for `sensors.SensorInfo`. Each is in its patch's frame."""

    def reader(
        self, calibration: Calibration, options: FeatureOptions | None = None
    ) -> GloveReader:
        """Return a reader of the features of each patch.

        Parameters
        ----------
        calibration
            Calibration of all tactels.
        options
            Detection and description of a contact. Patches are small: with `min_tactels` of 1, a
            single tactel is a contact.

        Raises
        ------
        InputError
            If the calibration belongs to another number of tactels.
        """
        count = len(self.array.positions)
        if len(calibration.rest) != count:
            raise InputError(
                f"the calibration must have {count} tactels like the glove, got "
                f"{len(calibration.rest)}"
            )
        readers = {
            name: FeatureReader(_part(calibration, self.slices[name]), array, options)
            for name, array in self.patches.items()
        }
        return GloveReader(readers, self.slices)


@dataclass(frozen=True)
class GloveReader:
    """The features of each patch of a glove, made by :meth:`Glove.reader`."""

    _readers: Mapping[str, FeatureReader]
    _slices: Mapping[str, slice]

    def read(self, raw: NDArray[np.uint16]) -> dict[str, ContactFeatures]:
        """Return the features of each patch, in its own frame, from readings (N,) uint16."""
        return {name: self._readers[name].read(raw[part]) for name, part in self._slices.items()}


@dataclass(frozen=True)
class HandFeatures:
    """The features of a whole hand, in the hand's frame. It is false without a contact."""

    touching: tuple[str, ...]
    """Names of the patches in contact."""
    force: NDArray[np.float64]
    """Sum of the forces on the object along the patches' normals, (3,), N."""
    torque: NDArray[np.float64]
    """Their torque about the hand's origin, (3,), N m."""
    squeeze: float
    """Sum of their magnitudes, N."""
    centre: NDArray[np.float64]
    """Mean of the centres of pressure, weighted by force, (3,), m; 0 without contact."""

    def __bool__(self) -> bool:
        return self.squeeze > 0.0

    @property
    def balance(self) -> float:
        """Share of the forces that oppose each other, 0..1: 0 is a push, 1 is a closed grip."""
        return 1.0 - float(np.linalg.norm(self.force)) / self.squeeze if self else 0.0

    @classmethod
    def of_patches(
        cls, features: Mapping[str, ContactFeatures], poses: Mapping[str, RigidTransform]
    ) -> HandFeatures:
        """Join the features of all patches to those of the hand.

        Parameters
        ----------
        features
            Features of each patch by its name.
        poses
            T_hand_patch of each of these patches, from the joints of the hand.

        Raises
        ------
        InputError
            If a patch in contact has no pose.
        """
        force, torque, centre, squeeze = np.zeros(3), np.zeros(3), np.zeros(3), 0.0
        touching = tuple(name for name, contact in features.items() if contact)
        for name in touching:
            if name not in poses:
                raise InputError(f"patch {name} has no pose; poses are known of {sorted(poses)}")
            contact, pose = features[name], poses[name]
            push = contact.force * pose.rotation.apply(contact.normal)
            place = pose.apply(contact.centre)
            force += push
            torque += np.cross(place, push)
            centre += contact.force * place
            squeeze += contact.force
        return cls(touching, force, torque, squeeze, centre / max(squeeze, 1e-300))


def _part(calibration: Calibration, part: slice) -> Calibration:
    names = ("raws", "pressures", "rest", "noise", "ceiling", "dead")
    return replace(calibration, **{name: getattr(calibration, name)[part] for name in names})
