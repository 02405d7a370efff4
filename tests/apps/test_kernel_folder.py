"""Kernels compile where no folder is writable."""

from pathlib import Path

import pytest

from eyehand.apps.kernel_folder import CACHE_VARIABLE, ensure_kernel_folder

UNWRITABLE = Path("/dev/null/folder")


@pytest.fixture(autouse=True)
def _no_variable(monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, "")


def test_temporary_folder_replaces_unwritable_ones(capsys, monkeypatch):
    folder = ensure_kernel_folder(UNWRITABLE, UNWRITABLE)
    assert folder is not None
    assert folder.is_dir()
    assert capsys.readouterr().err.count("\n") == 1
    # The variable is set now, so that the message appears once.
    assert ensure_kernel_folder(UNWRITABLE, UNWRITABLE) is None
    folder.rmdir()


@pytest.mark.parametrize("which", ["installation", "home"])
def test_writable_folder_is_left_to_numba(which, tmp_path, capsys):
    folders = {"installation": UNWRITABLE, "home": UNWRITABLE, which: tmp_path}
    assert ensure_kernel_folder(**folders) is None
    assert capsys.readouterr().err == ""
