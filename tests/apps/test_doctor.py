"""`eyehand doctor`: every part is reported, and only a missing core is a fault."""

import importlib
import json

import pytest

from eyehand.apps import doctor
from eyehand.apps.command_table import EXTRAS
from eyehand.apps.main import main


def report(capsys) -> tuple[int, dict]:
    """Run the command; return its exit code and its JSON object."""
    with pytest.raises(SystemExit) as exit_info:
        main(["doctor", "--json"])
    return int(exit_info.value.code or 0), json.loads(capsys.readouterr().out)


@pytest.fixture(autouse=True)
def quick(monkeypatch) -> None:
    """Search no camera, start no graphics, load no large library and compile nothing."""
    monkeypatch.setattr(doctor, "LOADERS", {})
    monkeypatch.setattr("eyehand.data_synth.render.gl_fault", lambda: "OpenGL is off; no display")
    monkeypatch.setattr(doctor, "_camera", lambda: doctor.Check("camera", False, "none", "connect"))
    # Modules that are imported while this is patched would keep the patch.
    for name in ("fit", "grasp_command", "perceive"):
        importlib.import_module(f"eyehand.apps.{name}")
    monkeypatch.setattr("eyehand.apps.perceived_frame.load_kernels", lambda: None)


def test_all_parts_are_reported(capsys):
    code, found = report(capsys)
    rows = {row["name"]: row for row in found["rows"]}
    assert code == 0
    assert found["schema"] == "eyehand.doctor/1"
    assert set(rows) == {
        *("kernels", "physics", "graphics", "films", "camera"),
        *(f"extra {extra}" for extra in EXTRAS.values()),
    }
    assert not rows["graphics"]["works"]
    assert "ray casting" in rows["graphics"]["detail"]
    assert rows["physics"]["detail"].startswith("MuJoCo ")


def test_missing_extra_names_its_install_command(capsys, monkeypatch):
    monkeypatch.setattr(doctor, "find_spec", lambda name: None if name == "mink" else object())
    code, found = report(capsys)
    (row,) = [row for row in found["rows"] if row["name"] == "extra baselines"]
    assert code == 0
    assert not row["works"]
    assert "no mink" in row["detail"]
    assert row["advice"] == "pip install 'eyehand[baselines]'"


def test_installed_package_that_cannot_be_imported_is_named(capsys, monkeypatch):
    def load():
        raise ImportError("libusb-1.0.so.0: cannot open\nshared object file")

    monkeypatch.setattr(doctor, "LOADERS", {"open3d": load})
    monkeypatch.setattr(doctor, "find_spec", lambda _name: object())
    code, found = report(capsys)
    (row,) = [row for row in found["rows"] if row["name"] == "extra baselines"]
    assert code == 0
    assert not row["works"]
    assert "open3d fails: libusb-1.0.so.0: cannot open shared object file" in row["detail"]


def test_broken_core_is_a_fault(capsys, monkeypatch):
    def broken():
        raise RuntimeError("libllvm\nis damaged")

    monkeypatch.setattr("eyehand.apps.perceived_frame.load_kernels", broken)
    code, found = report(capsys)
    assert code == 1
    assert found["rows"][0]["name"] == "kernels"
    assert "libllvm is damaged" in found["rows"][0]["detail"]


def test_table_shows_the_advice_with_its_brackets(capsys, monkeypatch):
    monkeypatch.setattr(doctor, "find_spec", lambda _name: None)
    with pytest.raises(SystemExit):
        main(["doctor"])
    assert "'eyehand[baselines]'" in capsys.readouterr().out


def test_shell_completion_knows_the_commands(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    with pytest.raises(SystemExit) as exit_info:
        main(["--install-completion", "--shell", "bash"])
    assert not exit_info.value.code, capsys.readouterr().err
    script = tmp_path / ".local/share/bash-completion/completions/eyehand"
    assert "calibrate" in script.read_text()
