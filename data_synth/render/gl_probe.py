"""Check in a child process whether this machine can render off-screen with OpenGL."""

from __future__ import annotations

import functools
import importlib.util
import os
import subprocess
import sys

_DISABLED = ("disable", "disabled", "off", "false", "0")
_MODULES = {
    "egl": "mujoco.egl",
    "osmesa": "mujoco.osmesa",
    "glfw": "mujoco.glfw",
    "cgl": "mujoco.cgl",
}
_DEFAULTS = {"linux": "mujoco.egl", "darwin": "mujoco.cgl"}
_TIMEOUT_S = 30.0
_PROBE = """
import importlib, sys
import mujoco
context = importlib.import_module(sys.argv[1]).GLContext(8, 8)
context.make_current()
model = mujoco.MjModel.from_xml_string("<mujoco/>")
drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, drawing)
drawing.free()
context.free()
"""


def gl_module() -> str | None:
    """Return the name of MuJoCo's module that opens contexts; None if `MUJOCO_GL` disables it.

    The default on Linux is EGL, which needs no display. The variable can name another.
    """
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if chosen in _DISABLED:
        return None
    return _MODULES.get(chosen, _DEFAULTS.get(sys.platform, _MODULES["glfw"]))


@functools.cache
def gl_fault() -> str:
    """Return why OpenGL cannot be used; empty if it can.

    A driver without hardware may crash instead of raising an error. So the first context is opened
    in a child process, which takes about a second. The result is kept for this process.
    """
    module = gl_module()
    if module is None:
        return f"MUJOCO_GL is {os.environ.get('MUJOCO_GL')!r}"
    if importlib.util.find_spec("OpenGL") is None:
        return "the Python package OpenGL is not installed; pip install 'eyehand[sim]'"
    try:
        probe = subprocess.run(
            [sys.executable, "-c", _PROBE, module],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"opening a context took more than {_TIMEOUT_S:g} s"
    except OSError as error:
        return f"the check could not be started ({error.strerror or error})"
    if probe.returncode == 0:
        return ""
    if probe.returncode < 0:
        return f"opening a context crashed (signal {-probe.returncode})"
    last = probe.stderr.strip().splitlines()[-1:] or [f"exit code {probe.returncode}"]
    return last[0]
