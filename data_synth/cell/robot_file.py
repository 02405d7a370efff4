"""Read and compile the files of robots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from eyehand.errors import InputError
from eyehand.grasping.hands import load_description

from ..mujoco_import import import_mujoco


def compile_robot(spec: Any, files: str) -> Any:
    """Compile a spec (`MjSpec`); ``files`` names it in the message of an `InputError`."""
    try:
        return spec.compile()
    except ValueError as error:
        raise InputError(f"MuJoCo cannot compile {files}: {' '.join(str(error).split())}") from None


def read_robot(path: Path) -> Any:
    """Read a robot's MJCF or URDF file as `MjSpec`; raise an `InputError` if that fails.

    Joints of a file without motors get one each, as those of a URDF. Its force is the joint's
    limit of effort.
    """
    if not Path(path).is_file():
        what = "this is a folder" if Path(path).is_dir() else "no such file"
        raise InputError(f"robot file {path}: {what}; give the path of an MJCF or URDF file")
    spec = load_description(path)
    if not list(spec.actuators):
        _add_motors(spec)
    return spec


def _add_motors(spec: Any) -> None:
    """Add a motor to each hinge and slide that follows no other joint."""
    mujoco = import_mujoco()
    kinds, couplings = mujoco.mjtJoint, list(spec.equalities)
    if any(one.type != mujoco.mjtEq.mjEQ_JOINT for one in couplings):
        return  # Joints of closed loops and tendons follow others, too.
    followers = {one.name1 for one in couplings if one.name2}
    for joint in spec.joints:
        if joint.type not in (kinds.mjJNT_HINGE, kinds.mjJNT_SLIDE) or not joint.name:
            continue
        if joint.name not in followers:
            motor = spec.add_actuator(
                name=f"{joint.name}_motor", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint.name
            )
            if joint.actfrcrange[1] > joint.actfrcrange[0]:
                motor.forcelimited, motor.forcerange = True, joint.actfrcrange
