"""Compiled kernels are deleted when a kernel of their package is newer, and only then."""

import os
import re
import time
from pathlib import Path

import pytest

from eyehand.errors.stale_kernels import KERNEL_PACKAGES, forget_stale_kernels

HOUR = 3600.0


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two kernels in tactile and one in control, compiled an hour after they were written."""
    for package, kernel in (("tactile", "push"), ("tactile", "press"), ("control", "reach")):
        cache = tmp_path / package / "__pycache__"
        cache.mkdir(parents=True, exist_ok=True)
        touch(tmp_path / package / f"{kernel}.py", hours_ago=2.0)
        touch(cache / f"{kernel}.step-12.py311.nbi", hours_ago=1.0)
    return tmp_path


def touch(file: Path, hours_ago: float):
    file.touch()
    at = time.time() - HOUR * hours_ago
    os.utime(file, (at, at))


def test_kernels_newer_than_all_sources_stay(root: Path):
    assert forget_stale_kernels(root) == []
    assert len(list(root.rglob("*.nbi"))) == 3


def test_a_changed_kernel_deletes_all_kernels_of_its_package(root: Path):
    touch(root / "tactile" / "push.py", hours_ago=0.5)
    assert len(forget_stale_kernels(root)) == 2
    assert [index.name for index in root.rglob("*.nbi")] == ["reach.step-12.py311.nbi"]


def test_a_kernel_compiled_after_the_change_stays(root: Path):
    touch(root / "tactile" / "push.py", hours_ago=0.5)
    touch(root / "tactile" / "__pycache__" / "push.step-12.py311.nbi", hours_ago=0.25)
    assert [index.name for index in forget_stale_kernels(root)] == ["press.step-12.py311.nbi"]


def test_changes_of_files_without_kernels_delete_nothing(root: Path):
    touch(root / "tactile" / "phases.py", hours_ago=0.5)
    assert forget_stale_kernels(root) == []


def test_a_changed_constant_deletes_the_kernels_that_import_it(root: Path):
    (root / "tactile" / "push.py").write_text("from .memory import (\n    DEPTH,\n)\n")
    touch(root / "tactile" / "push.py", hours_ago=2.0)
    touch(root / "tactile" / "memory.py", hours_ago=0.5)
    assert len(forget_stale_kernels(root)) == 2


def test_a_changed_class_deletes_nothing(root: Path):
    (root / "tactile" / "push.py").write_text("from .options import ServoOptions\n")
    touch(root / "tactile" / "push.py", hours_ago=2.0)
    touch(root / "tactile" / "options.py", hours_ago=0.5)
    assert forget_stale_kernels(root) == []


def test_a_source_dated_in_the_future_deletes_nothing(root: Path):
    touch(root / "tactile" / "push.py", hours_ago=-24.0)
    assert forget_stale_kernels(root) == []


def test_a_removed_source_deletes_nothing(root: Path):
    (root / "tactile" / "push.py").unlink()
    assert forget_stale_kernels(root) == []


def test_kernels_import_only_classes_from_other_packages():
    """The rule compares the times of files within one package."""
    tree = Path(__file__).parents[2]
    sources = [file for package in KERNEL_PACKAGES for file in (tree / package).rglob("*.py")]
    kernels = [text for text in (file.read_text() for file in sources) if "@njit" in text]
    assert len(kernels) > 100
    for text in kernels:
        for names in re.findall(r"^ *from eyehand\S* import (\([^)]*\)|.*)", text, re.MULTILINE):
            assert not re.search(r"\b([a-z]\w*|[A-Z][A-Z0-9_]+)\b", names), names
