"""The probe of the graphics library: a child process, and the reasons of a failure."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from eyehand.data_synth.render import gl_fault, gl_module


@pytest.fixture(autouse=True)
def _clear_cache() -> Iterator[None]:
    gl_fault.cache_clear()
    yield
    gl_fault.cache_clear()


def test_environment_variable_selects_or_disables_library(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    assert gl_module() == "mujoco.osmesa"
    monkeypatch.setenv("MUJOCO_GL", "off")
    assert gl_module() is None
    assert gl_fault() == "MUJOCO_GL is 'off'"


@pytest.mark.parametrize(("system", "library"), [("linux", "egl"), ("darwin", "cgl")])
def test_default_library_depends_on_system(
    monkeypatch: pytest.MonkeyPatch, system: str, library: str
):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(sys, "platform", system)
    assert gl_module() == f"mujoco.{library}"


def test_crash_of_driver_is_reported(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "eyehand.data_synth.render.gl_probe._PROBE", "import os; os.kill(os.getpid(), 11)"
    )
    assert gl_fault() == "opening a context crashed (signal 11)"


def test_exception_is_reported_by_its_last_line(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "eyehand.data_synth.render.gl_probe._PROBE", "raise RuntimeError('no display')"
    )
    assert gl_fault() == "RuntimeError: no display"


def test_hanging_driver_times_out(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("eyehand.data_synth.render.gl_probe._PROBE", "import time; time.sleep(60)")
    monkeypatch.setattr("eyehand.data_synth.render.gl_probe._TIMEOUT_S", 0.2)
    assert gl_fault() == "opening a context took more than 0.2 s"


def test_result_is_cached(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("eyehand.data_synth.render.gl_probe._PROBE", "")
    assert gl_fault() == ""

    def fail(*_: object, **__: object) -> None:
        raise AssertionError("probed twice")

    monkeypatch.setattr(subprocess, "run", fail)
    assert gl_fault() == ""
