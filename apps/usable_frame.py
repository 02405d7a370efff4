"""Refusal of frames from files that show no scene, or whose camera cannot be right."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.errors import InputError

if TYPE_CHECKING:
    from eyehand.perception import Segmentation

UNUSABLE = ("camera", "noise", "constant")
"""Kinds of warnings after which no result is of use. A live camera or a recording goes on after
them, because its next frame can be better. A file has no next frame."""


def check_usable(found: Segmentation, source: str = "") -> None:
    """Check that the frame of a segmentation can be used.

    Parameters
    ----------
    found
        The segmentation.
    source
        The file, for the message.

    Raises
    ------
    InputError
        If the frame shows noise or nothing, or the camera is implausible.
    """
    for warning in found.warnings:
        if warning.kind in UNUSABLE:
            raise InputError(f"{source}: {warning.message}" if source else warning.message)
