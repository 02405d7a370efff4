"""Warm-up compiles every kernel of the segmentation."""

import importlib
import pkgutil
import subprocess
import sys

import eyehand.perception.segmentation as package

SCRIPT = """
import importlib, pkgutil
from eyehand.perception.kernel_cache import warm_up
import eyehand.perception.segmentation as package
warm_up()
# These are compiled into their callers.
INNER = ("line_end", "plane_of_moments", "row_normals", "sample_pixel")
for module in pkgutil.iter_modules(package.__path__):
    imported = importlib.import_module(f"{package.__name__}.{module.name}")
    for name, function in vars(imported).items():
        inner = name.startswith("_") or name in INNER
        if not inner and hasattr(function, "py_func") and not function.nopython_signatures:
            print(module.name, name)
"""


def test_segmentation_has_kernels():
    names = [module.name for module in pkgutil.iter_modules(package.__path__)]
    kernels = [
        kernel
        for name in names
        for kernel in vars(importlib.import_module(f"{package.__name__}.{name}")).values()
        if hasattr(kernel, "nopython_signatures")
    ]
    assert len(kernels) > 10


def test_warm_up_compiles_every_kernel():
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True, timeout=300
    )
    assert done.stdout == ""
