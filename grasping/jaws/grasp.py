"""A planned grasp of parallel jaws, and the ranked list of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from .scoring import success_probability

APPROACH = 0.05
"""Length of the straight approach, m."""
RETREAT = 0.1
"""Distance that the hand draws back with the object, m."""


# Arrays and poses have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class Grasp:
    """One grasp.

    The tool frame has z along the approach, x along the closing direction, and its origin midway
    between the fingertips.
    """

    T_scene_tcp: RigidTransform
    """Pose of the tool frame at the grasp, in the frame of the `Scene` (world or camera)."""
    width: float
    """Distance between the pads before closing, m."""
    retreat_direction: NDArray[np.float64]
    """Unit direction in which the hand draws back with the object, (3,)."""
    object_label: int
    """Label of the object in the scene."""
    object_width: float
    """Expected distance between the pads when they touch the object, m."""
    success: float
    """Estimated probability of success, 0-1."""
    terms: Mapping[str, float]
    """Factors by name, each 0-1; `success` is their product, calibrated on executed grasps.
    The term of an unknown depth scale multiplies the calibrated product of the others."""
    reason: str
    """Description of the grasp for reports."""
    object_size: NDArray[np.float64] | None = None
    """Sizes of the object's largest solid along its axes, sorted, (3,), m. A failed grasp pushes
    its object: the next plan recognises it by them."""
    safe: bool = True
    """Whether nothing forbids to execute the grasp."""
    forbidden_by: tuple[str, ...] = ()
    """What forbids it: for example unseen space, or a width at the limit of the hand."""

    @property
    def pre_grasp(self) -> RigidTransform:
        """Pose of the tool frame before the straight approach."""
        return self._moved(-APPROACH * self.approach)

    @property
    def retreat(self) -> RigidTransform:
        """Pose of the tool frame to which the hand draws back with the object."""
        return self._moved(RETREAT * self.retreat_direction)

    def _moved(self, shift: NDArray[np.float64]) -> RigidTransform:
        return RigidTransform.from_translation(shift) * self.T_scene_tcp

    @property
    def position(self) -> NDArray[np.float64]:
        """Origin of the tool frame in the scene, (3,), m."""
        return np.asarray(self.T_scene_tcp.translation)

    @property
    def approach(self) -> NDArray[np.float64]:
        """Unit direction of the approach, (3,)."""
        return self.T_scene_tcp.as_matrix()[:3, 2]

    @property
    def closing(self) -> NDArray[np.float64]:
        """Unit direction of closing, (3,). Its sign has no meaning."""
        return self.T_scene_tcp.as_matrix()[:3, 0]

    @property
    def side(self) -> str:
        """Direction of the approach in words: ``from above``, ``oblique``, ``from the side``."""
        return self.reason.rpartition(", ")[2]

    @property
    def largest_doubt(self) -> str:
        """Name of the term that lowers `success` most."""

        def without(name: str) -> float:
            terms = {other: np.asarray(term) for other, term in self.terms.items()}
            return float(success_probability({**terms, name: np.ones(())}))

        return max(self.terms, key=without)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: the members of a grasp in `grasps.json`, without its rank."""
        return {
            "object": self.object_label,
            "success_pct": round(100 * self.success, 2),
            "safe": self.safe,
            "forbidden_by": list(self.forbidden_by),
            "approach": self.side,
            "object_width_mm": round(1e3 * self.object_width, 2),
            "opening_mm": round(1e3 * self.width, 2),
            "tool": _pose_dict(self.T_scene_tcp),
            "pre_grasp": _pose_dict(self.pre_grasp),
            "retreat": _pose_dict(self.retreat),
            "approach_direction": _rounded(self.approach),
            "closing_direction": _rounded(self.closing),
            "terms": {name: round(float(term), 4) for name, term in self.terms.items()},
        }


def _pose_dict(pose: RigidTransform) -> dict[str, list[float]]:
    return {
        "position_m": _rounded(pose.translation),
        "quat_wxyz": _rounded(pose.rotation.as_quat(scalar_first=True)),
    }


def _rounded(values: NDArray[np.float64]) -> list[float]:
    return [round(float(value), 6) for value in values]


@dataclass(frozen=True, eq=False)
class GraspList(Sequence[Grasp]):
    """Grasps of all objects, the most probable first. An empty list is false and has a reason."""

    grasps: tuple[Grasp, ...] = ()
    """The grasps."""
    reason: str = ""
    """Why the list is empty, or why none of its grasps is safe."""
    rejected: Mapping[int, Mapping[str, int]] = field(default_factory=dict)
    """Label of an object → reason → number of its candidates rejected for it."""
    seconds: float = 0.0
    """Time of planning, s."""

    def __len__(self) -> int:
        return len(self.grasps)

    @overload
    def __getitem__(self, index: int) -> Grasp: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Grasp, ...]: ...
    def __getitem__(self, index: int | slice) -> Grasp | tuple[Grasp, ...]:
        """Return a grasp, or a tuple of grasps."""
        return self.grasps[index]
