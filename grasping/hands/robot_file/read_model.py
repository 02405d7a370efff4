"""Read an MJCF or URDF file into a MuJoCo model for measurements without physics."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from eyehand.errors import InputError

from .mesh_bytes import mesh_shape
from .robot_xml import is_in_radians, read_xml
from .urdf_text import Urdf, prepared_urdf

MIN_MASS, MIN_INERTIA = 1e-6, 1e-9
"""Least mass, kg, and inertia, kg m². Without them MuJoCo refuses links without inertia."""

Model = Any
"""``mujoco.MjModel``: MuJoCo's binary parts carry no type stubs."""


def read_model(
    path: Path | str, package_dirs: Sequence[Path | str] = ()
) -> tuple[Model, tuple[str, ...]]:
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
    model, remarks
        The compiled model, and what was assumed. Links on fixed joints stay bodies of their own.

    Raises
    ------
    InputError
        If the file is no such file, or a number, a mesh or a joint in it is invalid.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    spec, remarks, urdf = _read(Path(path), package_dirs)
    mujoco = load_mujoco()
    spec.compiler.fusestatic = False
    spec.compiler.boundmass = max(spec.compiler.boundmass, MIN_MASS)
    spec.compiler.boundinertia = max(spec.compiler.boundinertia, MIN_INERTIA)
    spec.compiler.balanceinertia = True
    for mesh in spec.meshes:
        # Open meshes have no volume, and their inertia does not matter here.
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    try:
        return spec.compile(), remarks
    except (ValueError, KeyError, mujoco.FatalError) as error:
        raise _unreadable(Path(path), error, urdf) from None


def load_description(
    path: Path | str,
    *,
    package_dirs: Sequence[Path | str] = (),
    home: ArrayLike | None = None,
) -> Any:
    """Read a robot's MJCF or URDF file as `MjSpec`, with the same corrections as for a hand.

    The spec keeps the ``<limit velocity>`` of a URDF for `eyehand.control.RobotModel`, also after
    ``attach_body``. A gripper can be attached to it, and a frame or keyframe added.

    Parameters
    ----------
    path
        MJCF or URDF file. Mesh paths are relative to it.
    package_dirs
        Folders with ROS packages, for ``package://`` paths of a URDF. The folders above the file
        and those of ``ROS_PACKAGE_PATH`` are searched too.
    home
        Rest posture, one number for each joint of the file in its order, rad or m. It becomes the
        keyframe ``home``. MuJoCo appends the joints of a gripper that is attached later, at 0.

    Raises
    ------
    InputError
        If the file is invalid, or ``home`` does not fit its joints.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    spec, _, urdf = _read(Path(path), package_dirs)
    from eyehand.control import add_speed_limits

    if urdf is not None:
        spec = _without_files(Path(path), spec, urdf)
        add_speed_limits(spec, urdf.text)
    if home is not None:
        names = ", ".join(joint.name for joint in spec.joints)
        posture = np.asarray(home, dtype=np.float64)
        if posture.shape != (spec.compile().nq,) or not np.isfinite(posture).all():
            raise InputError(f"{path}: home must be finite numbers, one for each of {names}")
        spec.add_key(name="home", qpos=posture)
    return spec


def _without_files(path: Path, spec: Any, urdf: Urdf) -> Any:
    """Return the spec of a URDF with the corners of its meshes in place of files."""
    # MuJoCo looks for the files of all meshes in vain if a spec with contents in memory is attached
    # to another one. In the text of a spec, meshes are numbers.
    for mesh in spec.meshes:
        vertices, faces = mesh_shape(mesh.file, urdf.meshes[mesh.file])
        mesh.uservert, mesh.userface, mesh.file = vertices.ravel(), faces.ravel(), ""
    mujoco = load_mujoco()
    try:
        spec.compile()
        return mujoco.MjSpec.from_string(spec.to_xml())
    except (ValueError, KeyError, mujoco.FatalError) as error:
        raise _unreadable(path, error, urdf) from None


def load_mujoco() -> Any:
    """Import mujoco, which takes half a second; `eyehand.control` imports it without graphics.

    Raises
    ------
    DeviceError
        If it cannot be loaded.
    """
    importlib.import_module("eyehand.control")
    return importlib.import_module("mujoco")


def _read(
    path: Path, package_dirs: Sequence[Path | str]
) -> tuple[Any, tuple[str, ...], Urdf | None]:
    root = read_xml(path)
    mujoco = load_mujoco()
    urdf = prepared_urdf(path, root, package_dirs) if root.tag == "robot" else None
    try:
        if urdf is not None:
            return mujoco.MjSpec.from_string(urdf.text, assets=urdf.meshes), (), urdf
        spec = mujoco.MjSpec.from_file(str(path))
    except (ValueError, KeyError, mujoco.FatalError) as error:
        raise _unreadable(path, error, urdf) from None
    if not is_in_radians(path, root):
        return spec, (), None
    spec.compiler.degree = False
    remark = (
        "the angles are read in rad, because in degrees no hinge would turn by more than 3.15°; "
        '<compiler angle="radian"/> in the file would say so'
    )
    return spec, (remark,), None


def _unreadable(path: Path, error: Exception, urdf: Urdf | None) -> InputError:
    text = " ".join(str(error).split())
    for name, source in (urdf.sources if urdf else {}).items():
        text = text.replace(name, source)
    return InputError(f"{path}: MuJoCo cannot read it: {text.removeprefix('Error: ')}")
