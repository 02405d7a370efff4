"""`eyehand doctor`: report what works on this machine, and what to install for the rest."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from .bench.machine import machine_line
from .command_table import EXTRAS
from .console import print_json, show
from .kernel_folder import CACHE_VARIABLE
from .open3d_import import import_open3d

UDEV_RULES = Path("/etc/udev/rules.d/80-movidius.rules")
"""Rule that lets users without root open OAK cameras, as the manufacturer's guide names it."""
NEEDED = ("kernels", "physics")
"""Parts without which no command works."""
DISTRIBUTIONS = {
    "OpenGL": "pyopengl",
    "imageio_ffmpeg": "imageio-ffmpeg",
    "vtkmodules": "vtk",
    "gymnasium_robotics": "gymnasium-robotics",
    "mcap_ros2": "mcap-ros2-support",
    "mujoco_menagerie": "mujoco-menagerie",
}
"""Module → distribution, where their names differ."""

LOADERS: dict[str, Callable[[], object]] = {
    "open3d": import_open3d,
    "vtkmodules": lambda: import_module("vtkmodules.vtkRenderingOpenGL2"),
}
"""Import of the modules that need libraries of the system. An installed one may not load."""


class Check(NamedTuple):
    """The result of one check."""

    name: str
    """What was checked."""
    works: bool
    """Whether it can be used."""
    detail: str
    """Version, device or fault."""
    advice: str = ""
    """What to do if it does not work."""


def doctor_command(*, json: bool = False) -> int:
    """Report what works on this machine, and what to install for the rest.

    The exit code is 1 if perception cannot run. Extras that are not installed are no fault.

    Parameters
    ----------
    json
        Print one JSON object on stdout; the table goes to stderr.
    """
    from rich.markup import escape
    from rich.table import Table

    checks = [_checked(check) for check in (_kernels, _physics, _graphics, _films, _camera)]
    checks += [_extra(extra) for extra in dict.fromkeys(EXTRAS.values())]
    table = Table(title=machine_line(), title_justify="left")
    for column in ("part", "works", "found", "what to do"):
        table.add_column(column, overflow="fold")
    for check in checks:
        words = (check.name, "yes" if check.works else "no", check.detail, check.advice)
        table.add_row(*map(escape, words))
    show(table, json_wanted=json)
    if json:
        rows = [check._asdict() for check in checks]
        print_json("doctor", None, rows, machine=machine_line(), python=sys.version.split()[0])
    return int(any(check.name in NEEDED and not check.works for check in checks))


def _checked(check: Callable[[], Check]) -> Check:
    """Run a check. An exception of a damaged library is a result too."""
    try:
        return check()
    except Exception as error:
        fault = " ".join(str(error).split()) or type(error).__name__
        return Check(check.__name__.strip("_"), False, fault, "install eyehand again")


def _kernels() -> Check:
    from .perceived_frame import load_kernels

    load_kernels()
    folder = os.environ.get(CACHE_VARIABLE)
    return Check("kernels", True, f"compiled, stored in {folder}" if folder else "compiled")


def _physics() -> Check:
    from eyehand.data_synth import import_mujoco

    return Check("physics", True, f"MuJoCo {import_mujoco().__version__}")


def _graphics() -> Check:
    from eyehand.data_synth.render import gl_fault, gl_module

    fault = gl_fault()
    if not fault:
        return Check("graphics", True, f"OpenGL by {gl_module()}")
    advice = "pip install 'eyehand[sim]'" if "pip install" in fault else ""
    return Check(
        "graphics",
        False,
        f"{fault.partition(';')[0]}; slower ray casting is used",
        advice or "apt install libegl1 libgl1-mesa-dri",
    )


def _films() -> Check:
    if find_spec("imageio_ffmpeg") is None:
        return Check("films", False, "no encoder", "pip install 'eyehand[view]'")
    from imageio_ffmpeg import get_ffmpeg_exe

    program = shutil.which(get_ffmpeg_exe())
    return Check("films", program is not None, program or "ffmpeg cannot be run", "")


def _camera() -> Check:
    if find_spec("depthai") is None:
        return Check("camera", False, "no driver of OAK cameras", "pip install 'eyehand[oak]'")
    from eyehand.perception.cameras import load_depthai

    load_depthai()
    import depthai

    found = depthai.Device.getAllAvailableDevices()
    if found:
        return Check("camera", True, f"{len(found)} OAK camera: {found[0].deviceId}")
    advice = "connect an OAK camera"
    if sys.platform.startswith("linux") and os.getuid() and not UDEV_RULES.is_file():
        advice += f"; write its udev rule to {UDEV_RULES}"
    return Check("camera", False, "driver installed, no camera connected", advice)


def _extra(extra: str) -> Check:
    modules = [module for module, of in EXTRAS.items() if of == extra]
    missing = [module for module in modules if find_spec(module) is None]
    present = [module for module in modules if module not in missing]
    faults = [fault for module in present if (fault := _load_fault(module))]
    found = [*map(_version, present), *(f"no {module}" for module in missing), *faults]
    advice = f"pip install 'eyehand[{extra}]'" if missing else ""
    return Check(f"extra {extra}", not missing and not faults, ", ".join(found), advice)


def _load_fault(module: str) -> str:
    """Return why an installed module cannot be loaded; empty if it can, or was not tried."""
    try:
        LOADERS.get(module, str)()
    except Exception as error:
        return f"{module} fails: {' '.join(str(error).split()) or type(error).__name__}"
    return ""


def _version(module: str) -> str:
    name = DISTRIBUTIONS.get(module, module)
    try:
        return f"{name} {metadata.version(name)}"
    except metadata.PackageNotFoundError:
        return name
