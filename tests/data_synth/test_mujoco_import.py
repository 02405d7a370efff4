"""MuJoCo loads late, and also where its graphics library is missing."""

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


def test_physics_works_whatever_the_graphics_variable_says():
    code = (
        "import os\n"
        "from eyehand.data_synth.mujoco_import import import_mujoco\n"
        "model = import_mujoco().MjModel.from_xml_string('<mujoco/>')\n"
        "print(model.nbody, os.environ['MUJOCO_GL'])\n"
    )
    done = run(code, MUJOCO_GL="nonsense")
    assert done.stdout == "1 nonsense\n", done.stderr


def test_a_missing_package_is_named():
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
