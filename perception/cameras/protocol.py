"""The protocol of every source of depth frames."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

from ..frame import DepthFrame


@runtime_checkable
class Camera(Protocol):
    """A source of depth frames.

    The iterator, not the camera, owns an open device or pipeline. It releases them when it ends, is
    closed, or is deleted. A camera can therefore start several streams and needs no closing.
    """

    def frames(self) -> Iterator[DepthFrame]:
        """Return the frames in the order in which they were taken.

        Raises
        ------
        InputError
            If a file or folder with frames cannot be used.
        DeviceError
            If a device is missing or stops answering.
        """
        ...
