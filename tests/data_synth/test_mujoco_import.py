"""The late import of MuJoCo, without a graphics library and without the package."""

from __future__ import annotations

import os
import subprocess
import sys


def run(code: str, **variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )


def test_import_works_with_invalid_graphics_variable():
    code = (
        "import os\n"
        "from eyehand.data_synth.mujoco_import import import_mujoco\n"
        "model = import_mujoco().MjModel.from_xml_string('<mujoco/>')\n"
        "print(model.nbody, os.environ['MUJOCO_GL'])\n"
    )
    result = run(code, MUJOCO_GL="nonsense")
    assert result.stdout == "1 nonsense\n", result.stderr


def test_missing_package_raises_with_name():
    code = (
        "import sys\n"
        "class Missing:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'mujoco':\n"
        "            raise ModuleNotFoundError('none', name='mujoco')\n"
        "sys.meta_path.insert(0, Missing())\n"
        "from eyehand.errors import DeviceError\n"
        "from eyehand.data_synth.mujoco_import import import_mujoco\n"
        "try:\n"
        "    import_mujoco()\n"
        "except DeviceError as error:\n"
        "    print(error)\n"
    )
    assert "Python package mujoco is not installed" in run(code).stdout
