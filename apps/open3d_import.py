"""The import of open3d, which only benchmarks use: late, because it takes seconds."""

from __future__ import annotations

import ctypes
import importlib
import sys
from types import ModuleType

from eyehand.errors import DeviceError

DEBIAN_PACKAGES = "libgl1 libegl1 libx11-6 libidn2-0 libgomp1"
"""Debian packages with the system libraries that open3d's wheel links to but does not carry."""


def import_open3d() -> ModuleType:
    """Import open3d, after loading the libusb that the `libusb-package` wheel carries.

    Returns
    -------
    ModuleType
        The `open3d` module.

    Raises
    ------
    DeviceError
        If open3d is not installed or a system library it links to is missing.
    """
    loaded = sys.modules.get("open3d")
    if loaded is not None:
        return loaded
    try:
        libusb = importlib.import_module("libusb_package").get_library_path()
        # RTLD_GLOBAL, so that the loader takes this copy for open3d's own link to libusb-1.0.
        if libusb is not None:
            ctypes.CDLL(str(libusb), mode=ctypes.RTLD_GLOBAL)
        return importlib.import_module("open3d")
    except ModuleNotFoundError as error:
        raise DeviceError(
            f"cannot load open3d: the Python package {error.name or 'open3d'} is not installed; "
            "pip install 'eyehand[baselines]'"
        ) from error
    except (ImportError, OSError) as error:
        fault = " ".join(str(error).split())
        raise DeviceError(
            f"cannot load open3d ({fault}): on Debian or Ubuntu install {DEBIAN_PACKAGES}"
        ) from error
