#!/usr/bin/env python3
"""Build `.venv` from uv.lock on a machine that has only Python, make and git.

The Makefile runs this before every target, with a Python of the supported range; when `.venv` is
already as the lock says, it returns in a few milliseconds. Otherwise, in this order:

1. system libraries that the locked wheels load: installed with apt-get when root, else named;
2. uv: the one on PATH, or its own copy in `.uv/`;
3. `uv sync --frozen --all-extras`, into a new `.venv` unless this script finished the present one.

Standard library only: it runs before anything is installed.
"""

from __future__ import annotations

import ctypes
import fcntl
import hashlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
OWN_UV = ROOT / ".uv"
STAMP = VENV / ".ready.json"
"""Written last: a `.venv` without it was interrupted, or made by other means."""

MIN_UV = (0, 8)
"""Oldest uv that is used from PATH: the first with `uv venv --clear`."""

EGL_PLATFORM_DEVICE = 0x313F
MAX_EGL_DEVICES = 16
PROBE_TIMEOUT_S = 60
APT_LOCK_TIMEOUT_S = 120
"""A machine that has just started may still be running its own upgrades."""


@dataclass(frozen=True)
class SystemNeed:
    """Something outside Python that the set-up or the wheels load."""

    what: str
    """Name of the file or feature, as a loader would report it."""
    packages: tuple[str, ...]
    """Debian and Ubuntu packages that bring it."""
    required: bool = True
    """False: eyehand works without it, with less."""


SHARED_LIBRARIES = (
    SystemNeed("libEGL.so.1", ("libegl1",)),
    SystemNeed("libGL.so.1", ("libgl1",)),
    SystemNeed("libX11.so.6", ("libx11-6",)),
    SystemNeed("libidn2.so.0", ("libidn2-0",)),
    SystemNeed("libudev.so.1", ("libudev1",)),
)
"""What open3d's wheel links to and does not bring (its libusb comes from `libusb-package`)."""

RENDERER = SystemNeed("headless EGL", ("libegl-mesa0", "libgl1-mesa-dri"), required=False)
"""Without one, depth images come from ray casting and 3D pictures are left out."""


class SetupError(Exception):
    """The set-up cannot go on; the message is one line that says what to do."""


def main() -> int:
    """Make `.venv` ready, and return the process's exit code."""
    try:
        # Two targets started at once must not build the same folder: the second waits, then finds
        # it ready.
        with (ROOT / "pyproject.toml").open() as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not is_ready():
                provide_system_needs(needs_uv=uv_on_path() is None)
                sync(uv_on_path() or own_uv())
    except (SetupError, OSError) as error:
        _say(str(error))
        return 1
    except KeyboardInterrupt:
        _say("set-up interrupted: the next make starts it again")
        return 130
    return 0


def is_ready() -> bool:
    """Tell whether `.venv` was finished from today's lock, in this place, and is still whole."""
    stamp = _read_stamp()
    return stamp.get("inputs") == _inputs_digest() and _is_whole(stamp)


def sync(uv: Path) -> None:
    """Bring `.venv` to what uv.lock says; the stamp comes last."""
    keep = _is_whole(_read_stamp())
    STAMP.unlink(missing_ok=True)
    if not keep:
        # uv takes a package for installed when its dist-info is there: only a new environment heals
        # one that was interrupted between two files.
        _run(uv, "venv", "--quiet", "--clear", "--python", sys.executable, VENV)
    _say("installing the locked packages into .venv (about 1 GB to fetch if uv has none of them)")
    quiet = () if sys.stderr.isatty() else ("--quiet",)
    python = VENV / "bin" / "python"
    wanted = ("--frozen", "--all-extras", "--reinstall-package", "eyehand")
    _run(uv, "sync", *wanted, *quiet, "--python", python)
    write_stamp()


def write_stamp() -> None:
    """Record that `.venv` is complete, from which inputs, and what it holds."""
    stamp = {"root": str(ROOT), "inputs": _inputs_digest(), "names": _venv_names()}
    partial = STAMP.with_suffix(".partial")
    partial.write_text(json.dumps(stamp))
    partial.replace(STAMP)


def provide_system_needs(*, needs_uv: bool) -> None:
    """Install what the system lacks, or say in one line what to install.

    Raises
    ------
    SetupError
        If something required stays missing.
    """
    missing = missing_system_needs(needs_uv=needs_uv)
    if missing and os.geteuid() == 0 and shutil.which("apt-get"):
        reason = _apt_install(missing)
        missing = missing_system_needs(needs_uv=needs_uv)
    else:
        reason = ""
    if not missing:
        return
    line = f"missing {', '.join(need.what for need in missing)}{reason}; {_remedy(missing)}"
    if any(need.required for need in missing):
        raise SetupError(line)
    _say(f"{line} (going on without: depth images will come from ray casting)")


def missing_system_needs(*, needs_uv: bool) -> list[SystemNeed]:
    """List what is missing, found by loading it: package databases differ between systems."""
    missing = []
    if needs_uv and not _has_own_uv() and importlib.util.find_spec("ensurepip") is None:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        missing.append(SystemNeed(f"Python {version}'s venv", (f"python{version}-venv",)))
    if sys.platform != "linux":
        return missing
    libraries = [need for need in SHARED_LIBRARIES if not _loads(need.what)]
    missing += libraries
    if any("EGL" in need.what for need in libraries) or not _renderer_answers():
        missing.append(RENDERER)
    return missing


def uv_on_path() -> Path | None:
    """Return the uv on PATH if it runs and is new enough."""
    found = shutil.which("uv")
    if found is None:
        return None
    version = re.match(r"uv (\d+)\.(\d+)", _output(found, "--version"))
    if version is None or (int(version[1]), int(version[2])) < MIN_UV:
        return None
    return Path(found)


def own_uv() -> Path:
    """Return the uv in `.uv/`, put there first if it is not."""
    if not _has_own_uv():
        _say("installing uv into .uv")
        _run(sys.executable, "-m", "venv", "--clear", OWN_UV)
        _run(OWN_UV / "bin" / "python", "-m", "pip", "install", "--quiet", "uv")
    return OWN_UV / "bin" / "uv"


def renders_headless() -> bool:
    """Tell whether an EGL device opens without a display, as MuJoCo's and VTK's renderers need."""
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    egl.eglGetProcAddress.argtypes = [ctypes.c_char_p]
    egl.eglInitialize.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    pointer = ctypes.c_void_p
    query = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, pointer, pointer)
    display_of = ctypes.CFUNCTYPE(pointer, ctypes.c_uint, pointer, pointer)
    addresses = [
        egl.eglGetProcAddress(name) for name in (b"eglQueryDevicesEXT", b"eglGetPlatformDisplayEXT")
    ]
    if not all(addresses):
        return False
    devices, count = (pointer * MAX_EGL_DEVICES)(), ctypes.c_int(0)
    query(addresses[0])(MAX_EGL_DEVICES, devices, ctypes.addressof(count))
    displays = (
        display_of(addresses[1])(EGL_PLATFORM_DEVICE, device, None)
        for device in devices[: count.value]
    )
    return any(display and egl.eglInitialize(display, None, None) for display in displays)


def _renderer_answers() -> bool:
    """Probe in a process of its own: a half-installed driver may end it."""
    try:
        probe = [sys.executable, __file__, "--probe-renderer"]
        return (
            subprocess.run(probe, capture_output=True, timeout=PROBE_TIMEOUT_S, check=False)
        ).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _apt_install(needs: list[SystemNeed]) -> str:
    """Install the packages of `needs`; return what apt-get complained of, or nothing."""
    packages = _packages(needs)
    _say(f"installing system packages: {' '.join(packages)}")
    apt = ["apt-get", "-qq", "-o", f"DPkg::Lock::Timeout={APT_LOCK_TIMEOUT_S}"]
    quietly = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    for command in (["update"], ["install", "-y", "--no-install-recommends", *packages]):
        done = subprocess.run(
            [*apt, *command],
            env=quietly,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            check=False,
        )
    if done.returncode == 0:
        return ""
    complaints = [line for line in done.stdout.splitlines() if line.startswith("E:")]
    return f" (apt-get: {complaints[-1][2:].strip()})" if complaints else " (apt-get failed)"


def _remedy(needs: list[SystemNeed]) -> str:
    packages = " ".join(_packages(needs))
    if shutil.which("apt-get"):
        return f"install with: sudo apt-get update && sudo apt-get install -y {packages}"
    return f"install them with this system's package manager (on Debian: {packages})"


def _packages(needs: list[SystemNeed]) -> list[str]:
    return sorted({package for need in needs for package in need.packages})


def _has_own_uv() -> bool:
    return _output(OWN_UV / "bin" / "uv", "--version").startswith("uv ")


def _inputs_digest() -> str:
    digest = hashlib.sha256()
    for path in (ROOT / "pyproject.toml", ROOT / "uv.lock", Path(__file__)):
        digest.update(path.read_bytes())
    # setuptools' editable finder takes a folder that had no __init__.py for a namespace, and keeps
    # to it until the package is installed again.
    packages = sorted(ROOT.glob("[!.]*/__init__.py")) + sorted(ROOT.glob("[!.]*/*/__init__.py"))
    digest.update("\n".join(str(path.relative_to(ROOT)) for path in packages).encode())
    return digest.hexdigest()


def _read_stamp() -> dict[str, object]:
    try:
        return json.loads(STAMP.read_text())
    except (OSError, ValueError):
        return {}


def _is_whole(stamp: dict[str, object]) -> bool:
    """Tell whether the environment still has all it was finished with, and its Python runs."""
    names = stamp.get("names")
    if stamp.get("root") != str(ROOT) or not isinstance(names, list):
        return False
    if not set(names) <= set(_venv_names()):
        return False
    # A system upgrade may leave `python` dangling, or turn it into a Python that looks for its
    # packages in another folder.
    finds = "import importlib.util as u, sys; sys.exit(u.find_spec('pytest') is None)"
    return _succeeds(VENV / "bin" / "python", "-c", finds)


def _venv_names() -> list[str]:
    folders = [VENV / "bin", *VENV.glob("lib/python3*/site-packages")]
    names = (path.relative_to(VENV) for folder in folders for path in folder.glob("*"))
    return sorted(str(name) for name in names if name.name != "__pycache__")


def _run(*command: str | Path) -> None:
    """Run a step of the set-up from the project's folder, with its output shown."""
    environment = {**os.environ, "UV_PROJECT_ENVIRONMENT": str(VENV)}
    environment.pop("VIRTUAL_ENV", None)
    done = subprocess.run([str(word) for word in command], cwd=ROOT, env=environment, check=False)
    if done.returncode != 0:
        step = " ".join([Path(command[0]).name, *map(str, command[1:3])])
        raise SetupError(f"`{step}` failed (its own words are above)")


def _succeeds(*command: str | Path) -> bool:
    try:
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def _output(*command: str | Path) -> str:
    """Return what a command prints, or nothing when it fails or is not there."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout if done.returncode == 0 else ""


def _say(line: str) -> None:
    sys.stderr.write(f"eyehand: {line}\n")
    sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(not renders_headless() if sys.argv[1:] == ["--probe-renderer"] else main())
