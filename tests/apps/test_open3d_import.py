"""The import of open3d."""

from __future__ import annotations

import importlib
import subprocess
import sys
from typing import Any

import pytest

from eyehand.apps.open3d_import import import_open3d
from eyehand.errors import DeviceError


def test_reading_files_loads_no_heavy_package() -> None:
    program = (
        "import sys, eyehand.perception.io.depth_frame, eyehand.perception.io.point_cloud; "
        "sys.exit('open3d' in sys.modules or 'matplotlib' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_open3d_loads_once() -> None:
    open3d = import_open3d()
    assert open3d.__name__ == "open3d"
    assert import_open3d() is open3d


def test_missing_system_library_names_the_packages_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _fail_to_import(
        monkeypatch, OSError("libGL.so.1: cannot open shared object file: No such file")
    )
    with pytest.raises(DeviceError) as caught:
        import_open3d()
    message = str(caught.value)
    assert "libGL.so.1: cannot open shared object file" in message
    assert "install libgl1 libegl1 libx11-6 libidn2-0 libgomp1" in message
    assert "\n" not in message


def test_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    _fail_to_import(monkeypatch, ModuleNotFoundError("No module", name="open3d"))
    with pytest.raises(DeviceError, match="the Python package open3d is not installed"):
        import_open3d()


def _fail_to_import(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    import_module = importlib.import_module

    def importing(name: str, package: str | None = None) -> Any:
        if name == "open3d":
            raise error
        return import_module(name, package)

    monkeypatch.delitem(sys.modules, "open3d", raising=False)
    monkeypatch.setattr(importlib, "import_module", importing)
