"""Read the XML of a robot's file, and check it before MuJoCo reads it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from eyehand.errors import InputError, named_files

MAX_BYTES = 20_000_000
"""Maximum size of a robot's XML file. Geometry belongs into mesh files."""
MAX_INCLUDED = 50
"""Maximum number of files that a file may include."""
MAX_SEARCHED = 200
"""Maximum number of files that are searched for one that includes another."""
MAX_RADIANS = 3.15
"""Greatest angle of a file that was probably meant in rad but is read in degrees."""
UNBOUND = "urn:unbound:"
"""Namespace of prefixes that a file uses without declaring them."""
_TEXTS = ("name", "filename", "file", "class", "childclass", "mesh", "joint", "body", "link")
"""Attributes that are names. A name may be ``nan``."""
_ANGLES = ("euler", "axisangle")
"""Attributes with angles, besides the range of a joint."""


def read_xml(path: Path) -> ElementTree.Element:
    """Read an MJCF or URDF file. Undeclared prefixes, as of Drake's tags, are declared.

    Raises
    ------
    InputError
        If it cannot be read, or is the part of a robot that another file includes.
    """
    root = _parsed_file(path)
    named_files(path)  # MuJoCo would wait for a FIFO without end.
    if root.tag == "mujocoinclude" or (root.tag == "mujoco" and root.find("body") is not None):
        whole = _including(path)
        hint = f": give that file, such as {whole}" if whole else ""
        raise InputError(f"{path} is a part of a robot that another file includes{hint}")
    if root.tag not in ("mujoco", "robot"):
        raise InputError(f"{path}: the root element must be <mujoco> or <robot>, got <{root.tag}>")
    for element in elements(path, root):
        for name, value in element.attrib.items():
            if name not in _TEXTS and not _is_finite(value):
                raise InputError(f"{path}: {name} of <{element.tag}> must be finite, got {value!r}")
    return root


def elements(path: Path, root: ElementTree.Element) -> Iterator[ElementTree.Element]:
    """Yield the elements of an MJCF and of the files that it includes."""
    waiting, seen = [(path.resolve(), root)], set[Path]()
    while waiting:
        where, tree = waiting.pop()
        for element in tree.iter():
            yield element
            included = element.get("file")
            if element.tag == "include" and included is not None:
                other = (path.parent / included).resolve()
                other = other if other.exists() else (where.parent / included).resolve()
                if other not in seen and len(seen) < MAX_INCLUDED and other.is_file():
                    seen.add(other)
                    waiting.append((other, _parsed_file(other)))


def is_in_radians(path: Path, root: ElementTree.Element) -> bool:
    """Return whether an MJCF that does not name the unit of its angles must mean rad.

    The default is degrees. A part of a robot can leave the unit to the file that it is joined to:
    then every hinge has a range of at most ±3.15.
    """
    ranges = []
    for element in elements(path, root):
        if element.tag == "compiler" and "angle" in element.attrib:
            return False
        hinge = element.tag == "joint" and element.get("type", "hinge") == "hinge"
        names = (*_ANGLES, *(("range",) if hinge else ()))
        for name in names:
            values = element.get(name, "").split()
            ranges += [abs(float(one)) for one in (values[3:] if name == "axisangle" else values)]
    return bool(ranges) and 0.0 < max(ranges) <= MAX_RADIANS


def _parsed_file(path: Path) -> ElementTree.Element:
    try:
        if not path.exists():
            raise InputError(f"there is no file {path}")
        if not path.is_file():
            raise InputError(f"{path} must be a file, but it is a folder, FIFO or device")
        size = path.stat().st_size
        if size == 0:
            raise InputError(f"{path} is empty; it must be an MJCF or URDF file")
        if size > MAX_BYTES:
            raise InputError(
                f"{path} has {size / 1e6:.0f} MB; an MJCF or URDF file has at most "
                f"{MAX_BYTES / 1e6:.0f} MB"
            )
        return _parsed(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: this is no MJCF or URDF file: {error}") from None


def _parsed(content: bytes) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        if "unbound prefix" not in str(error):
            raise
    declared = set(re.findall(rb"xmlns:([\w.-]+)", content))
    used = set(re.findall(rb"[</\s]([\w.-]+):[\w.-]+[\s/>=]", content)) - declared - {b"xmlns"}
    names = b"".join(b' xmlns:%s="%s%s"' % (one, UNBOUND.encode(), one) for one in sorted(used))
    root = ElementTree.fromstring(re.sub(rb"(<[A-Za-z][\w.-]*)", rb"\1" + names, content, count=1))
    # What a tool added for itself, such as <drake:proximity_properties>, says nothing to others.
    for parent in list(root.iter()):
        for child in [one for one in parent if UNBOUND in str(one.tag)]:
            parent.remove(child)
    return root


def _including(path: Path) -> Path | None:
    """Return a file in the folder of a part, above it or beside it, that includes the part."""
    above = path.resolve().parent.parent
    for files in (path.parent.glob("*.xml"), above.glob("*.xml"), above.glob("*/*.xml")):
        for other in sorted(files)[:MAX_SEARCHED]:
            if other != path and other.is_file() and other.stat().st_size < MAX_BYTES:
                text = other.read_text(errors="replace")
                if re.search(rf'<include\s+file="(?:[^"]*/)?{re.escape(path.name)}"', text):
                    return other
    return None


def _is_finite(text: str) -> bool:
    lowered = text.lower()
    if "nan" not in lowered and "inf" not in lowered:
        return True
    for word in text.split():
        try:
            if not math.isfinite(float(word)):
                return False
        except ValueError:
            continue
    return True
