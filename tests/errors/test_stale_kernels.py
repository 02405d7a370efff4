"""Compiled kernels are deleted when a kernel source of their package changes, and only then."""

import os
import re
import time
from pathlib import Path

import numba
import pytest

from eyehand.errors.stale_kernels import KERNEL_PACKAGES, RECORD, forget_stale_kernels


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two kernels in tactile and one in control, compiled since the last start."""
    for package, kernel in (("tactile", "push"), ("tactile", "press"), ("control", "reach")):
        cache = tmp_path / package / "__pycache__"
        cache.mkdir(parents=True, exist_ok=True)
        (tmp_path / package / f"{kernel}.py").write_text("")
    (tmp_path / "tactile" / "phases.py").write_text("")
    assert forget_stale_kernels(tmp_path) == []
    compile_kernels(tmp_path)
    return tmp_path


def compile_kernels(root: Path):
    for package, kernel in (("tactile", "push"), ("tactile", "press"), ("control", "reach")):
        (root / package / "__pycache__" / f"{kernel}.step-12.py311.nbi").touch()


def compiled(root: Path) -> list[str]:
    return sorted(index.name.partition(".")[0] for index in root.rglob("*.nbi"))


def test_kernels_of_unchanged_sources_stay(root: Path):
    assert forget_stale_kernels(root) == []
    assert compiled(root) == ["press", "push", "reach"]


def test_a_changed_kernel_deletes_all_kernels_of_its_package_once(root: Path):
    (root / "tactile" / "push.py").write_text("changed")
    assert len(forget_stale_kernels(root)) == 2
    assert compiled(root) == ["reach"]
    compile_kernels(root)
    assert forget_stale_kernels(root) == []


@pytest.mark.parametrize("hours", [-1000.0, 24.0], ids=["older", "in the future"])
def test_a_source_of_another_time_is_a_change(root: Path, hours: float):
    """Copies and archives keep the time at which a source was written elsewhere."""
    at = time.time() + 3600.0 * hours
    os.utime(root / "tactile" / "push.py", (at, at))
    assert len(forget_stale_kernels(root)) == 2
    compile_kernels(root)
    assert forget_stale_kernels(root) == []


def test_kernels_without_a_record_are_deleted(root: Path):
    (root / "tactile" / "__pycache__" / RECORD).unlink()
    forget_stale_kernels(root)
    assert compiled(root) == ["reach"]


def test_files_without_kernels_delete_nothing(root: Path):
    (root / "tactile" / "phases.py").write_text("changed")
    (root / "tactile" / "new.py").symlink_to("nothing.py")
    assert forget_stale_kernels(root) == []


@pytest.mark.parametrize(
    ("names", "deleted"), [("(\n    DEPTH,\n)", 2), ("ServoOptions", 0)], ids=["constant", "class"]
)
def test_a_changed_constant_deletes_the_kernels_that_import_it(root: Path, names, deleted):
    (root / "tactile" / "push.py").write_text(f"from .phases import {names}\n")
    forget_stale_kernels(root)
    compile_kernels(root)
    (root / "tactile" / "phases.py").write_text("changed")
    assert len(forget_stale_kernels(root)) == deleted


def test_kernels_in_a_chosen_folder_are_deleted_too(root: Path, tmp_path_factory, monkeypatch):
    chosen = tmp_path_factory.mktemp("kernels")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(chosen))
    # numba has read the variable already.
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(chosen))
    source = root / "tactile" / "push.py"
    index = numba_folder(source) / "push.step-12.py311.nbi"
    forget_stale_kernels(root)
    index.touch()
    assert forget_stale_kernels(root) == []
    source.write_text("changed")
    assert forget_stale_kernels(root) == [index]
    assert compiled(root) == ["press", "push", "reach"]


def numba_folder(source: Path) -> Path:
    """Return the folder that numba itself chooses for the kernels of a source."""
    space: dict = {"__name__": "kernels"}
    source.write_text("def step():\n    return 0\n")
    exec(compile(source.read_text(), str(source), "exec"), space)
    return Path(str(numba.njit(cache=True)(space["step"]).stats.cache_path))


def test_a_moved_tree_keeps_its_kernels(root: Path, tmp_path_factory):
    moved = root.rename(tmp_path_factory.mktemp("elsewhere") / "tree")
    assert forget_stale_kernels(moved) == []


def test_a_folder_without_the_right_to_write_is_no_error(root: Path, monkeypatch):
    def refused(*_, **__):
        raise PermissionError

    (root / "tactile" / "push.py").write_text("changed")
    monkeypatch.setattr(Path, "unlink", refused)
    monkeypatch.setattr(Path, "write_text", refused)
    assert forget_stale_kernels(root) == []


def test_kernels_import_only_classes_from_other_packages():
    """The rule compares the sources of one package."""
    tree = Path(__file__).parents[2]
    sources = [file for package in KERNEL_PACKAGES for file in (tree / package).rglob("*.py")]
    kernels = [text for text in (file.read_text() for file in sources) if "@njit" in text]
    assert len(kernels) > 100
    for text in kernels:
        for names in re.findall(r"^ *from eyehand\S* import (\([^)]*\)|.*)", text, re.MULTILINE):
            assert not re.search(r"\b([a-z]\w*|[A-Z][A-Z0-9_]+)\b", names), names
