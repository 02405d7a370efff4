"""The files that an MJCF or URDF names: includes, meshes, textures, height fields."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from .base import InputError

FILE_PREFIX = "file"
"""Prefix of the attributes that name a file (`file`, `filename`, `fileup`, ...)."""
FOLDER_ATTRIBUTES = ("meshdir", "texturedir", "assetdir")
"""MJCF attributes that name the folders of these files."""


def named_files(path: Path) -> list[Path]:
    """Return the existing files that a robot's file names, recursively, in the order of reading.

    Raises
    ------
    InputError
        If it names a FIFO or a device: a reader would wait for it without end.
    """
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
                if place.exists() and not place.is_dir():
                    raise InputError(
                        f"robot: {file} names {place}, which must be a file, but it is a FIFO or "
                        "device"
                    )
                continue
            found[place] = None
            if place.suffix in (".xml", ".mjcf", ".urdf") and place not in read:
                waiting.append(place)
    return list(found)


def _read(file: Path) -> tuple[list[str], list[str]]:
    """Return the names of files and folders in an XML file; none if it is not XML."""
    try:
        elements = list(ElementTree.parse(file).iter())
    except (ElementTree.ParseError, OSError, ValueError, LookupError):
        return [], []
    names = [
        value
        for element in elements
        for key, value in element.attrib.items()
        if key.startswith(FILE_PREFIX) and value and "\0" not in value
    ]
    folders = [
        element.attrib[key] for element in elements for key in FOLDER_ATTRIBUTES if element.get(key)
    ]
    return list(dict.fromkeys(names)), list(dict.fromkeys(folders))
