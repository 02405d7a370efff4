"""What every source of depth frames does: a device, a recording, a folder of files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ..frame import DepthFrame


@runtime_checkable
class Camera(Protocol):
    """A source of depth frames.

    Whatever a stream holds open (a device, a pipeline) belongs to the iterator, not to the camera:
    it is let go when the iterator ends, is closed, or is dropped. A camera can therefore be asked
    for frames again, and needs no closing itself.
    """

    def frames(self) -> Iterator[DepthFrame]:
        """Frames in the order they were taken, each (H, W) float32 depth in m.

        Raises
        ------
        InputError
            If what the frames are read from (a file, a folder) cannot be used.
        DeviceError
            If a device is missing or stops answering.
        """
        ...
