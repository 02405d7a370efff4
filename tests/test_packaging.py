"""The folders install as one package, and the arrows between them are those of DESIGN.md."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

ARROWS = {
    "errors": set(),
    "perception": {"errors"},
    "control": {"errors"},
    "tactile": {"errors"},
    "grasping": {"errors", "perception", "control", "tactile"},
    "data_synth": {"errors", "perception", "tactile", "grasping"},
    "apps": {"errors", "perception", "control", "tactile", "grasping", "data_synth"},
}
"""Room -> the other rooms that it may import (DESIGN.md, "Rooms")."""

HEAVY = ("open3d", "pyvista", "depthai", "mujoco", "matplotlib")
"""Distributions that only the functions needing them load: each costs from 0.2 s to 2 s."""

LIGHT_ENTRIES = ("perception", "grasping", "tactile", "data_synth", "apps", "apps.main", "control")
"""What a person imports first; control last, since it loads its engine."""
ENGINES = {"eyehand.control": ["mujoco"]}
"""Robot models are MuJoCo's: who imports the control basis is about to load one."""


def test_every_folder_with_code_is_a_listed_package_and_no_other_is():
    setuptools = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {folder: folder.replace("/", ".") for folder in _code_folders()}

    assert set(setuptools["packages"]) == {f"eyehand.{name}" for name in folders.values()}
    assert setuptools["package-dir"] == {
        f"eyehand.{name}": folder for folder, name in folders.items()
    }


def test_every_top_package_ships_its_type_marker():
    setuptools = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    assert "py.typed" in setuptools["package-data"]["*"]
    for package in ARROWS:
        assert (ROOT / package / "py.typed").is_file()


def test_every_package_imports_under_its_name_from_its_own_folder():
    for folder in _code_folders():
        package = importlib.import_module(f"eyehand.{folder.replace('/', '.')}")
        assert package.__file__ is not None, f"{folder}/__init__.py missing, or .venv older than it"
        assert Path(package.__file__).resolve() == ROOT / folder / "__init__.py"


def test_eyehand_itself_stays_a_namespace():
    assert not (ROOT / "__init__.py").exists()
    spec = importlib.util.find_spec("eyehand")
    assert spec is not None
    assert spec.origin is None


def test_imports_follow_the_arrows_between_the_rooms():
    faults = [
        f"{path.relative_to(ROOT)}:{line}: {fault}"
        for room in ARROWS
        for path in sorted((ROOT / room).rglob("*.py"))
        for line, fault in _import_faults(path.read_text(), path.relative_to(ROOT))
    ]
    assert not faults, "\n".join(faults)


def test_no_test_imports_a_room_by_its_bare_name():
    faults = [
        f"{path.relative_to(ROOT)}:{line}: imports {name}"
        for path in sorted((ROOT / "tests").rglob("*.py"))
        for line, name in _imported_names(path.read_text(), path.relative_to(ROOT))
        if name.partition(".")[0] in ARROWS
    ]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize(
    ("source", "path", "fault"),
    [
        ("import eyehand.apps.main", "grasping/pick.py", "grasping may not import apps"),
        ("from eyehand import control", "perception/a.py", "perception may not import control"),
        ("from eyehand.control import plan", "data_synth/a.py", "may not import control"),
        ("def f():\n    from eyehand import tactile", "control/a.py", "may not import tactile"),
        ("from perception import DepthFrame", "grasping/a.py", "bare perception"),
        ("import data_synth.scenes as s", "apps/a.py", "bare data_synth"),
        ("from ..tactile import slip", "grasping/a.py", "relative import into tactile"),
        ("from ...errors import InputError", "perception/cameras/a.py", "relative import into"),
        ("from .. import control", "apps/__init__.py", "relative import into control"),
        ('import_module("eyehand.control.qp")', "tactile/a.py", "may not import control"),
    ],
)
def test_an_import_against_the_arrows_is_found(source: str, path: str, fault: str):
    (found,) = [text for _, text in _import_faults(source, Path(path))]
    assert fault in found


@pytest.mark.parametrize(
    ("source", "path"),
    [
        ("from eyehand.errors import InputError", "perception/frame.py"),
        ("from eyehand.perception.frame import DepthFrame", "data_synth/camera.py"),
        ("from . import frame\nfrom .frame import DepthFrame", "perception/__init__.py"),
        ("from ..frame import DepthFrame", "perception/cameras/file.py"),
        ("import numpy as np\nfrom scipy import optimize", "control/qp.py"),
        ("import eyehand.control, eyehand.grasping", "apps/main.py"),
    ],
)
def test_an_import_along_the_arrows_is_let_through(source: str, path: str):
    assert list(_import_faults(source, Path(path))) == []


def test_importing_a_room_loads_no_heavy_library():
    entries = [
        f"eyehand.{entry}"
        for entry in LIGHT_ENTRIES
        if (ROOT / entry.replace(".", "/")).is_dir()
        or (ROOT / entry.replace(".", "/")).with_suffix(".py").is_file()
    ]
    # One process for all: what one entry loads stays loaded, so the first one reported is to blame.
    program = (
        "import importlib, json, sys\n"
        "loaded = {}\n"
        f"for entry in {entries!r}:\n"
        "    importlib.import_module(entry)\n"
        f"    loaded[entry] = [name for name in {HEAVY!r} if name in sys.modules]\n"
        "print(json.dumps(loaded))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert done.returncode == 0, done.stderr
    expected = {entry: ENGINES.get(entry, []) for entry in entries}
    assert json.loads(done.stdout.splitlines()[-1]) == expected


def test_commands_load_without_extras():
    # The core has no extras: there the help, and the completion of the shell, import all commands.
    program = (
        "import importlib, sys\n"
        "from eyehand.apps.command_table import COMMANDS, EXTRAS\n"
        "sys.modules.update(dict.fromkeys([*EXTRAS, 'PIL']))\n"
        "for where, _ in COMMANDS.values():\n"
        "    importlib.import_module(where.partition(':')[0])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr


def _code_folders() -> list[str]:
    """List the folders of the rooms that hold Python files, as paths from the root."""
    files = (path for room in ARROWS for path in (ROOT / room).rglob("*.py"))
    return sorted({path.parent.relative_to(ROOT).as_posix() for path in files})


def _import_faults(source: str, path: Path) -> list[tuple[int, str]]:
    """List the imports that go against the arrows, each with its line."""
    room = path.parts[0]
    faults = []
    for line, name in _imported_names(source, path):
        top, _, rest = name.partition(".")
        target = rest.partition(".")[0]
        if top in ARROWS:
            faults.append((line, f"bare {name}: import eyehand.{name}"))
        elif top == "<relative>" and target != room:
            faults.append((line, f"relative import into {target}: import eyehand.{target}"))
        elif top == "eyehand" and target != room and target not in ARROWS[room]:
            faults.append((line, f"{room} may not import {target or 'eyehand as a whole'}"))
    return faults


def _imported_names(source: str, path: Path) -> list[tuple[int, str]]:
    """List every module or member that a file imports, anywhere in it, by dotted name.

    A relative import comes back as `<relative>.<room>...`, resolved from the file's own folder.
    """
    names = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module.split(".") if node.module else []
            if node.level:
                package = path.parent.parts
                kept = package[: len(package) - (node.level - 1)]
                base = ["<relative>", *kept, *base]
            names += [(node.lineno, ".".join([*base, alias.name])) for alias in node.names]
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(
            ("import_module", "__import__")
        ):
            names += [
                (node.lineno, argument.value)
                for argument in node.args
                if isinstance(argument, ast.Constant) and isinstance(argument.value, str)
            ]
    return names
