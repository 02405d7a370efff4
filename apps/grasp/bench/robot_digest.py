"""A digest of all files that make up a robot: its MJCF, what that names, its hand's description."""

from __future__ import annotations

import hashlib
from pathlib import Path
from xml.etree import ElementTree

from eyehand.data_synth.cell import DESCRIPTION_SUFFIX

DIGITS = 12
"""Letters of a digest: enough to tell any two robots apart."""
FILE = "file"
"""With this begins each attribute of MJCF that names a file (`file`, `fileup`, ...) ..."""
FOLDERS = ("meshdir", "texturedir", "assetdir")
"""... and these name folders in which it is looked for."""


def robot_digest(path: Path) -> str:
    """Digest a robot's files; another hand, finger or mesh is another robot.

    Parameters
    ----------
    path
        MJCF file. What it includes or names is read with it, as far as it is there, and
        ``robot.hand.json`` beside ``robot.xml``.
    """
    files = [path, path.with_suffix(DESCRIPTION_SUFFIX), *_named(path)]
    digest = hashlib.sha256()
    for file in dict.fromkeys(files):
        if file.is_file():
            content = file.read_bytes()
            digest.update(f"{file.name} {len(content)} ".encode() + content)
    return digest.hexdigest()[:DIGITS]


def _named(path: Path) -> list[Path]:
    """Files that an MJCF names, those that they name, and so on, in the order of reading."""
    found: dict[Path, None] = {}
    folders = {path.parent: None}
    waiting, read = [path], set[Path]()
    while waiting:
        file = waiting.pop(0)
        read.add(file)
        names, inner = _read(file)
        folders |= {file.parent: None}
        folders |= {home / name: None for name in inner for home in list(folders)}
        # A folder may be named after what lies in it: what was not found is looked for again.
        for place in [home / name for home in folders for name in names]:
            if not place.is_file():
                continue
            found[place] = None
            if place.suffix in (".xml", ".mjcf") and place not in read:
                waiting.append(place)
    return list(found)


def _read(file: Path) -> tuple[list[str], list[str]]:
    """Names of files and of folders in an MJCF; none where it is no XML."""
    try:
        elements = list(ElementTree.parse(file).iter())
    except (ElementTree.ParseError, OSError):
        return [], []
    names = [
        value
        for element in elements
        for key, value in element.attrib.items()
        if key.startswith(FILE) and value
    ]
    folders = [element.attrib[key] for element in elements for key in FOLDERS if element.get(key)]
    return list(dict.fromkeys(names)), list(dict.fromkeys(folders))
