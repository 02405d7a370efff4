"""Read an MJCF or URDF file into a MuJoCo model for measurements without physics."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from eyehand.errors import InputError, named_files

from .urdf_text import Urdf, prepared_urdf

MAX_BYTES = 20_000_000
"""Maximum size of a robot's XML file. Geometry belongs into mesh files."""
MAX_INCLUDED = 50
"""Maximum number of files that a file may include."""
MIN_MASS, MIN_INERTIA = 1e-6, 1e-9
"""Least mass, kg, and inertia, kg m². Without them MuJoCo refuses links without inertia."""

Model = Any
"""``mujoco.MjModel``: MuJoCo's binary parts carry no type stubs."""


def read_model(path: Path | str, package_dirs: Sequence[Path | str] = ()) -> Model:
    """Read a robot's file.

    Parameters
    ----------
    path
        MJCF or URDF file. Mesh paths are relative to it.
    package_dirs
        Folders with ROS packages, for ``package://`` paths of a URDF. The folders above the file
        and those of ``ROS_PACKAGE_PATH`` are searched too.

    Returns
    -------
    Model
        The compiled model. Links on fixed joints stay bodies of their own.

    Raises
    ------
    InputError
        If the file is no such file, or a number, a mesh or a joint in it is invalid.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    path = Path(path)
    root = _read_xml(path)
    named_files(path)  # MuJoCo would wait for a FIFO without end.
    if root.tag not in ("mujoco", "robot"):
        raise InputError(f"{path}: the root element must be <mujoco> or <robot>, got <{root.tag}>")
    for element, name, value in _numbers(path, root):
        raise InputError(f"{path}: {name} of <{element}> must be finite, got {value!r}")
    mujoco = load_mujoco()
    if root.tag == "robot":
        return _compiled(mujoco, path, prepared_urdf(path, root, package_dirs))
    return _compiled(mujoco, path, None)


def load_mujoco() -> Any:
    """Import mujoco, which takes half a second; `eyehand.control` imports it without graphics.

    Raises
    ------
    DeviceError
        If it cannot be loaded.
    """
    importlib.import_module("eyehand.control")
    return importlib.import_module("mujoco")


def _compiled(mujoco: Any, path: Path, urdf: Urdf | None) -> Model:
    try:
        if urdf is None:
            spec = mujoco.MjSpec.from_file(str(path))
        else:
            spec = mujoco.MjSpec.from_string(urdf.text, assets=urdf.meshes)
        spec.compiler.fusestatic = False
        spec.compiler.boundmass = max(spec.compiler.boundmass, MIN_MASS)
        spec.compiler.boundinertia = max(spec.compiler.boundinertia, MIN_INERTIA)
        spec.compiler.balanceinertia = True
        for mesh in spec.meshes:
            # Open meshes have no volume, and their inertia does not matter here.
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        return spec.compile()
    except (ValueError, KeyError, mujoco.FatalError) as error:
        text = " ".join(str(error).split())
        for name, source in (urdf.sources if urdf else {}).items():
            text = text.replace(name, source)
        raise InputError(f"{path}: MuJoCo cannot read it: {text.removeprefix('Error: ')}") from None


def _read_xml(path: Path) -> ElementTree.Element:
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
        return ElementTree.fromstring(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: this is no MJCF or URDF file: {error}") from None


def _numbers(path: Path, root: ElementTree.Element) -> Iterator[tuple[str, str, str]]:
    """Yield the numbers of a file and of those that it includes which are not finite.

    MuJoCo prints a warning for them, and accepts infinite sizes.
    """
    waiting, seen = [(path.resolve(), root)], set[Path]()
    while waiting:
        where, tree = waiting.pop()
        for element in tree.iter():
            for name, value in element.attrib.items():
                if name in _TEXTS or not _is_finite(value):
                    if name not in _TEXTS:
                        yield str(element.tag), name, value
                    continue
            included = element.get("file")
            if element.tag == "include" and included is not None:
                other = (path.parent / included).resolve()
                other = other if other.exists() else (where.parent / included).resolve()
                if other not in seen and len(seen) < MAX_INCLUDED and other.is_file():
                    seen.add(other)
                    waiting.append((other, _read_xml(other)))


_TEXTS = ("name", "filename", "file", "class", "childclass", "mesh", "joint", "body", "link")
"""Attributes that are names. A name may be ``nan``."""


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
