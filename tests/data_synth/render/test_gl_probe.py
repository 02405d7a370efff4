"""The graphics library is tried in a child process, and its failure is told in words."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from eyehand.data_synth.render import gl_fault, gl_module


@pytest.fixture(autouse=True)
def _fresh_answer() -> Iterator[None]:
    gl_fault.cache_clear()
    yield
    gl_fault.cache_clear()


def test_the_variable_chooses_or_forbids(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    assert gl_module() == "mujoco.osmesa"
    monkeypatch.setenv("MUJOCO_GL", "off")
    assert gl_module() is None
    assert gl_fault() == "MUJOCO_GL is 'off'"


@pytest.mark.parametrize(("system", "library"), [("linux", "egl"), ("darwin", "cgl")])
def test_each_system_has_its_off_screen_library(
    monkeypatch: pytest.MonkeyPatch, system: str, library: str
):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(sys, "platform", system)
    assert gl_module() == f"mujoco.{library}"


def test_a_crash_of_the_driver_is_only_an_answer(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "eyehand.data_synth.render.gl_probe._PROBE", "import os; os.kill(os.getpid(), 11)"
    )
    assert gl_fault() == "opening a context crashed (signal 11)"


def test_an_exception_is_told_by_its_last_line(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "eyehand.data_synth.render.gl_probe._PROBE", "raise RuntimeError('no display')"
    )
    assert gl_fault() == "RuntimeError: no display"


def test_a_hanging_driver_is_given_up(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("eyehand.data_synth.render.gl_probe._PROBE", "import time; time.sleep(60)")
    monkeypatch.setattr("eyehand.data_synth.render.gl_probe._TIMEOUT_S", 0.2)
    assert gl_fault() == "opening a context took more than 0.2 s"


def test_the_answer_is_kept(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("eyehand.data_synth.render.gl_probe._PROBE", "")
    assert gl_fault() == ""

    def never(*_: object, **__: object) -> None:
        raise AssertionError("probed twice")

    monkeypatch.setattr(subprocess, "run", never)
    assert gl_fault() == ""
