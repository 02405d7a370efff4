"""Warming up leaves no kernel of the segmentation uncompiled."""

import importlib
import pkgutil
import subprocess
import sys

import eyehand.perception.segmentation as room

SCRIPT = """
import importlib, pkgutil
from eyehand.perception.kernel_cache import warm_up
import eyehand.perception.segmentation as room
warm_up()
for module in pkgutil.iter_modules(room.__path__):
    for name, kernel in vars(importlib.import_module(f"{room.__name__}.{module.name}")).items():
        private = name.startswith("_")  # compiled with those that call them
        if not private and hasattr(kernel, "py_func") and not kernel.nopython_signatures:
            print(module.name, name)
"""


def test_the_segmentation_has_kernels():
    names = [module.name for module in pkgutil.iter_modules(room.__path__)]
    kernels = [
        kernel
        for name in names
        for kernel in vars(importlib.import_module(f"{room.__name__}.{name}")).values()
        if hasattr(kernel, "nopython_signatures")
    ]
    assert len(kernels) > 10


def test_every_kernel_is_ready_after_warming_up():
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True, timeout=300
    )
    assert done.stdout == ""
