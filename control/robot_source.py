"""Read a robot from MJCF or URDF, and the joint speed limits that MuJoCo leaves out."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from eyehand.errors import InputError

from .mujoco_binding import Model, Spec, mujoco

Source = str | Path | Spec
"""Path of an MJCF or URDF file, its text, or an MjSpec."""

SPEED_NUMERIC = "joint_speed"
"""Name of the ``<custom><numeric>`` of an MJCF that holds joint speed limits."""


def read_robot(source: Source) -> tuple[Spec, dict[str, float]]:
    """Read a robot; meshes are looked for relative to the file.

    Returns
    -------
    spec, urdf_speed
        A spec of one's own, with fixed links kept as bodies (a tool frame is one), and the
        ``<limit velocity>`` of a URDF by joint name (empty for the rest).

    Raises
    ------
    InputError
        If the file is missing or MuJoCo cannot read it.
    """
    if not isinstance(source, (str, Path)):
        if not isinstance(source, mujoco.MjSpec):
            raise InputError(f"robot: give a path, XML text or an MjSpec, got {source!r}")
        return _own(source.copy()), {}
    if isinstance(source, str) and source.lstrip().startswith("<"):
        return _own(_parsed(source)), _urdf_speed(source)
    path = Path(source)
    if not path.is_file():
        raise InputError(f"robot: no such file: {path}; give a path of an MJCF or URDF file")
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except (ValueError, mujoco.FatalError) as error:
        hint = "" if path.suffix in (".xml", ".urdf") else "; its name must end in .xml or .urdf"
        raise InputError(f"robot: cannot read {path}: {_one_line(error)}{hint}") from None
    # The other formats that MuJoCo reads are not XML and hold no such limits.
    # As bytes: the file itself names its encoding.
    text = path.read_bytes() if path.suffix.lower() in (".xml", ".urdf") else b""
    return _own(spec), _urdf_speed(text)


def compile_spec(spec: Spec) -> Model:
    """Compile, with MuJoCo's message as an :class:`InputError` when it cannot."""
    try:
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(f"robot: MuJoCo cannot compile it: {_one_line(error)}") from None


def _own(spec: Spec) -> Spec:
    # Of a URDF, MuJoCo would merge links on fixed joints, and frames to control would be lost.
    spec.compiler.fusestatic = False
    return spec


def _parsed(text: str) -> Spec:
    try:
        return mujoco.MjSpec.from_string(text)
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(f"robot: cannot read the XML text: {_one_line(error)}") from None


def _urdf_speed(text: str | bytes) -> dict[str, float]:
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return {}
    speeds: dict[str, float] = {}
    for joint in root.findall("joint") if root.tag == "robot" else []:
        limit = joint.find("limit")
        value = None if limit is None else limit.get("velocity")
        name = joint.get("name")
        if value is None or name is None:
            continue
        try:
            speeds[name] = float(value)
        except ValueError:
            raise InputError(f"robot: joint {name}: velocity {value!r} is no number") from None
    return speeds


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
