"""A digest of all files of a robot: its MJCF, the files it names, and the hand description."""

from __future__ import annotations

import hashlib
from pathlib import Path

from eyehand.data_synth.cell import DESCRIPTION_SUFFIX
from eyehand.errors import named_files

DIGEST_LENGTH = 12
"""Number of letters of a digest."""


def robot_digest(path: Path) -> str:
    """Return a digest of the files of a robot. It changes with any hand, finger or mesh.

    Parameters
    ----------
    path
        MJCF file. The existing files that it includes or names are read as well, and
        ``robot.hand.json`` beside ``robot.xml``.
    """
    files = [path, path.with_suffix(DESCRIPTION_SUFFIX), *named_files(path)]
    digest = hashlib.sha256()
    for file in dict.fromkeys(files):
        if file.is_file():
            content = file.read_bytes()
            digest.update(f"{file.name} {len(content)} ".encode() + content)
    return digest.hexdigest()[:DIGEST_LENGTH]
