"""The wheel and the source archive are complete, and run away from the repository."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("apps", "control", "data_synth", "errors", "grasping", "perception", "tactile")
DATA = (".css", ".json", ".png", ".typed", ".xml")
"""Suffixes of the files that the packages read besides Python."""


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    """Return a folder with the wheel and the source archive, built in a copy of the repository."""
    folder = tmp_path_factory.mktemp("built")
    copy = folder / "copy"
    ignored = shutil.ignore_patterns("__pycache__", ".*", "*.egg-info", "out", "typings")
    shutil.copytree(ROOT, copy, ignore=ignored, symlinks=True)
    program = (
        "from setuptools.build_meta import build_sdist, build_wheel\n"
        f"build_wheel({str(folder)!r})\nbuild_sdist({str(folder)!r})\n"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=copy, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    shutil.rmtree(copy)
    return folder


@pytest.fixture(scope="module")
def python(built) -> Path:
    """Return the Python of an environment with the wheel and the present dependencies."""
    environment = built / "environment"
    venv.create(environment)
    (site,) = environment.glob("lib/python3*/site-packages")
    (wheel,) = built.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(site)
    # A path file inside this folder is not read again: the editable install stays out.
    (site / "present.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return environment / "bin" / "python"


def run(python: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python outside the repository, without the variables that lead into it."""
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONPATH"}
    folder = python.parents[2]
    return subprocess.run(
        [str(python), *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )


def package_files() -> set[str]:
    """Return the files of the packages, relative to the repository."""
    return {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.suffix in (".py", *DATA) and path.parent.name != "__pycache__"
    }


def test_wheel_holds_every_file_of_the_packages(built):
    (wheel,) = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    inside = {name.removeprefix("eyehand/") for name in names if name.startswith("eyehand/")}
    assert inside == package_files()
    (entry,) = [name for name in names if name.endswith("entry_points.txt")]
    text = zipfile.ZipFile(wheel).read(entry).decode()
    assert "eyehand = eyehand.apps.main:main" in text
    assert wheel.stat().st_size < 5e6


def test_source_archive_holds_what_a_build_needs(built):
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as file:
        names = {name.partition("/")[2] for name in file.getnames()}
    assert package_files() | {"pyproject.toml", "README.md", "LICENSE"} <= names


def test_installed_packages_import_and_answer_away_from_the_repository(python):
    program = (
        "import pkgutil, importlib, json, eyehand\n"
        "names = [one.name for one in pkgutil.walk_packages(eyehand.__path__, 'eyehand.')\n"
        "         if one.ispkg]\n"
        "places = [importlib.import_module(name).__file__ for name in names]\n"
        "print(json.dumps(places))\n"
    )
    done = run(python, "-c", program)
    assert done.returncode == 0, done.stderr
    places = json.loads(done.stdout)
    assert len(places) > 20
    assert all(place.startswith(str(python.parents[1])) for place in places)
    done = run(python, "-m", "eyehand.apps", "--version")
    assert done.returncode == 0, done.stderr
    assert "0.1.0" in done.stdout


@pytest.mark.slow
def test_installed_commands_run_away_from_the_repository(python):
    (sample,) = python.parents[1].glob("lib/python3*/site-packages/eyehand/apps/sample/depth.png")
    done = run(python, "-m", "eyehand.apps", "perceive", str(sample), "--json", "--out", "mine")
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)["rows"]
    assert [row["name"] for row in rows] == ["frame", *(f"object {k}" for k in range(1, 7))]
    assert (python.parents[2] / "mine" / "scene.json").is_file()
    done = run(python, "-m", "eyehand.apps", "grasp", str(sample), "--hand", "panda", "--json")
    assert done.returncode == 0, done.stderr
