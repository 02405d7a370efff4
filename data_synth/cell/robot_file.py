"""Read and compile the MJCF files of robots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from eyehand.errors import InputError, named_files

from ..mujoco_import import import_mujoco


def compile_robot(spec: Any, files: str) -> Any:
    """Compile a spec (`MjSpec`); ``files`` names it in the message of an `InputError`."""
    try:
        return spec.compile()
    except ValueError as error:
        raise InputError(f"MuJoCo cannot compile {files}: {' '.join(str(error).split())}") from None


def read_robot(path: Path) -> Any:
    """Read a robot's MJCF file as `MjSpec`; raise an `InputError` if that fails."""
    mujoco = import_mujoco()
    if not Path(path).is_file():
        what = "this is a folder" if Path(path).is_dir() else "no such file"
        raise InputError(f"robot file {path}: {what}; give the path of an MJCF file")
    named_files(Path(path))  # MuJoCo would wait for a FIFO without end.
    try:
        return mujoco.MjSpec.from_file(str(path))
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(
            f"cannot read the robot file {path}: {' '.join(str(error).split())}"
        ) from None
