"""A digest of all files of a robot: its MJCF, the files it names, and the hand description."""

from __future__ import annotations

import hashlib
from pathlib import Path
from xml.etree import ElementTree

from eyehand.data_synth.cell import DESCRIPTION_SUFFIX

DIGEST_LENGTH = 12
"""Number of letters of a digest."""
FILE_PREFIX = "file"
"""Prefix of the MJCF attributes that name a file (`file`, `fileup`, ...)."""
FOLDER_ATTRIBUTES = ("meshdir", "texturedir", "assetdir")
"""MJCF attributes that name the folders of these files."""


def robot_digest(path: Path) -> str:
    """Return a digest of the files of a robot. It changes with any hand, finger or mesh.

    Parameters
    ----------
    path
        MJCF file. The existing files that it includes or names are read as well, and
        ``robot.hand.json`` beside ``robot.xml``.
    """
    files = [path, path.with_suffix(DESCRIPTION_SUFFIX), *_named(path)]
    digest = hashlib.sha256()
    for file in dict.fromkeys(files):
        if file.is_file():
            content = file.read_bytes()
            digest.update(f"{file.name} {len(content)} ".encode() + content)
    return digest.hexdigest()[:DIGEST_LENGTH]


def _named(path: Path) -> list[Path]:
    """Return the files that an MJCF names, recursively, in the order of reading."""
    found: dict[Path, None] = {}
    folders = {path.parent: None}
    waiting, read = [path], set[Path]()
    while waiting:
        file = waiting.pop(0)
        read.add(file)
        names, inner = _read(file)
        folders |= {file.parent: None}
        folders |= {home / name: None for name in inner for home in list(folders)}
        # A folder attribute can follow its files, so search all names again.
        for place in [home / name for home in folders for name in names]:
            if not place.is_file():
                continue
            found[place] = None
            if place.suffix in (".xml", ".mjcf") and place not in read:
                waiting.append(place)
    return list(found)


def _read(file: Path) -> tuple[list[str], list[str]]:
    """Return the names of files and folders in an MJCF; none if it is not XML."""
    try:
        elements = list(ElementTree.parse(file).iter())
    except (ElementTree.ParseError, OSError):
        return [], []
    names = [
        value
        for element in elements
        for key, value in element.attrib.items()
        if key.startswith(FILE_PREFIX) and value
    ]
    folders = [
        element.attrib[key] for element in elements for key in FOLDER_ATTRIBUTES if element.get(key)
    ]
    return list(dict.fromkeys(names)), list(dict.fromkeys(folders))
