"""Read a robot from MJCF or URDF, and the joint speed limits that MuJoCo does not read."""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

from eyehand.errors import InputError, named_files

from .mujoco_binding import Model, Spec, mujoco

PACKAGE = "package://"
"""Start of a path in a ROS package."""
Source = str | Path | Spec
"""Path of an MJCF or URDF file, XML text, or an MjSpec."""

SPEED_NUMERIC = "joint_speed"
"""Name of the ``<custom><numeric>`` element of an MJCF that holds joint speed limits. With a point
and the name of a joint, it holds the limit of this joint: names keep in step where a spec is
attached to another one with a prefix."""
ACCELERATION_NUMERIC, JERK_NUMERIC = "joint_acceleration", "joint_jerk"
"""Names of the elements with the limits of acceleration and jerk."""


def read_robot(source: Source, package_dirs: Sequence[str | Path] = ()) -> Spec:
    """Read a robot. Mesh paths are relative to the file, or ``package://`` paths of a URDF.

    Returns
    -------
    spec
        A new spec, with the speed limits of a URDF (:func:`add_speed_limits`). Links on fixed
        joints stay separate bodies, because a tool frame can be such a link.

    Raises
    ------
    InputError
        If the file is missing or names a FIFO, MuJoCo cannot read it, or a package is in no folder.
    """
    if not isinstance(source, (str, Path)):
        if not isinstance(source, mujoco.MjSpec):
            raise InputError(
                f"robot: the source must be a path, XML text or an MjSpec, got {source!r}"
            )
        return _keep_fixed_links(source.copy())
    if isinstance(source, str) and source.lstrip().startswith("<"):
        return _read_text(resolve_packages(source, package_dirs), "the XML text")
    path = Path(source)
    if not path.is_file():
        raise InputError(
            f"robot: no such file: {path}; the path must be that of an MJCF or URDF file"
        )
    named_files(path)  # MuJoCo would wait for a FIFO without end.
    if path.suffix.lower() in (".xml", ".urdf"):
        text = path.read_bytes().decode(errors="replace")
        if PACKAGE in text:
            return _read_text(resolve_packages(text, package_dirs), str(path))
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except (ValueError, mujoco.FatalError) as error:
        hint = "" if path.suffix in (".xml", ".urdf") else "; its name must end in .xml or .urdf"
        raise InputError(f"robot: cannot read {path}: {_one_line(error)}{hint}") from None
    # Only XML holds speed limits. Read as bytes, because the file itself declares its encoding.
    text = path.read_bytes() if path.suffix.lower() in (".xml", ".urdf") else b""
    add_speed_limits(spec, text)
    return _keep_fixed_links(spec)


def resolve_packages(text: str, package_dirs: Sequence[str | Path]) -> str:
    """Return a URDF with absolute paths in place of ``package://NAME/...``.

    Raises
    ------
    InputError
        If a package is in none of the folders.
    """
    names = sorted(set(re.findall(PACKAGE + r"([^/\"'\s<]+)", text)))
    if not names:
        return text
    variables = [os.environ.get(name, "") for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")]
    folders = [Path(folder) for folder in package_dirs]
    for folder in os.pathsep.join(variables).split(os.pathsep):
        folders += [Path(folder), Path(folder) / "share"] if folder else []
    for name in names:
        # A folder may be the package itself, as in ROS_PACKAGE_PATH.
        found = [folder / name for folder in folders if (folder / name).is_dir()]
        found += [folder for folder in folders if folder.name == name and folder.is_dir()]
        if not found:
            looked = ", ".join(map(str, folders)) or "none"
            raise InputError(
                f"robot: package {name!r} of {PACKAGE}{name} must be in a folder of package_dirs, "
                f"ROS_PACKAGE_PATH or AMENT_PREFIX_PATH; folders: {looked}"
            )
        text = text.replace(f"{PACKAGE}{name}/", f"{found[0].resolve()}/")
    if "<mujoco" not in text:
        # By default MuJoCo removes the folders from the paths of a URDF.
        text = re.sub(
            r"(<robot\b[^>]*>)", r'\1<mujoco><compiler strippath="false"/></mujoco>', text, count=1
        )
    return text


def _read_text(text: str, name: str) -> Spec:
    try:
        spec = mujoco.MjSpec.from_string(text)
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(f"robot: cannot read {name}: {_one_line(error)}") from None
    add_speed_limits(spec, text)
    return _keep_fixed_links(spec)


def compile_spec(spec: Spec) -> Model:
    """Compile a spec; raise an :class:`InputError` with MuJoCo's message if that fails."""
    try:
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(f"robot: MuJoCo cannot compile the model: {_one_line(error)}") from None


def _keep_fixed_links(spec: Spec) -> Spec:
    # By default MuJoCo merges the links of a URDF on fixed joints, and their frames are lost.
    spec.compiler.fusestatic = False
    return spec


def add_speed_limits(spec: Spec, text: str | bytes) -> None:
    """Add the ``<limit velocity>`` of the text of a URDF to its spec. MuJoCo does not read them.

    Raises
    ------
    InputError
        If a velocity is not a number.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return
    for joint in root.findall("joint") if root.tag == "robot" else []:
        limit = joint.find("limit")
        value = None if limit is None else limit.get("velocity")
        name = joint.get("name")
        if value is None or name is None:
            continue
        try:
            speed = float(value)
        except ValueError:
            raise InputError(
                f"robot: joint {name}: velocity must be a number, got {value!r}"
            ) from None
        if speed:  # Many URDF files write 0 for an unknown limit.
            spec.add_numeric(name=f"{SPEED_NUMERIC}.{name}", data=[speed], size=1)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
