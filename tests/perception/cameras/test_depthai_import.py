"""Tests of loading depthai: late, without output, in a version that has the names in use."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import eyehand.perception.cameras
from eyehand.errors import InputError
from eyehand.perception.cameras.depthai_import import LEVEL_VARIABLE, load_depthai

FOLDER = Path(eyehand.perception.cameras.__file__).parent

LIST_LOADED_SCRIPT = """
import json, sys
import eyehand.perception.cameras
heavy = [name for name in ("depthai", "open3d", "pyvista", "matplotlib") if name in sys.modules]
print(json.dumps(heavy))
"""

LOAD_SCRIPT = """
from eyehand.perception.cameras.depthai_import import load_depthai
load_depthai()
import depthai
depthai.Pipeline(createImplicitDevice=False)
"""


def run(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    inherited = {k: v for k, v in os.environ.items() if k != LEVEL_VARIABLE}
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        env=inherited | environment,
    )


def test_importing_cameras_does_not_load_depthai() -> None:
    assert json.loads(run(LIST_LOADED_SCRIPT).stdout) == []


def test_loading_depthai_prints_nothing() -> None:
    process = run(LOAD_SCRIPT)

    assert (process.stdout, process.stderr) == ("", "")


def test_log_level_of_user_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LEVEL_VARIABLE, "OFF")
    load_depthai()
    assert os.environ[LEVEL_VARIABLE] == "OFF"

    monkeypatch.setenv(LEVEL_VARIABLE, "")
    load_depthai()
    assert os.environ[LEVEL_VARIABLE] == "error"


def test_unknown_log_level_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LEVEL_VARIABLE, "critical")

    with pytest.raises(InputError, match="DEPTHAI_LEVEL is 'critical': must be one of trace"):
        load_depthai()


def depthai_attributes(tree: ast.AST) -> set[tuple[str, ...]]:
    """Return every attribute chain `dai.x.y.z` of a module, without `dai`."""
    found = set()
    for node in ast.walk(tree):
        names: list[str] = []
        while isinstance(node, ast.Attribute):
            names.append(node.attr)
            node = node.value
        if names and isinstance(node, ast.Name) and node.id == "dai":
            found.add(tuple(reversed(names)))
    return found


@pytest.mark.parametrize("path", sorted(FOLDER.glob("oak*.py")), ids=lambda p: p.stem)
def test_used_depthai_names_exist(path: Path) -> None:
    load_depthai()
    import depthai as dai

    for chain in depthai_attributes(ast.parse(path.read_text(encoding="utf-8"))):
        member = dai
        for name in chain:
            assert hasattr(member, name), f"depthai has no {'.'.join(chain)}"
            member = getattr(member, name)


@pytest.mark.parametrize(
    ("owner", "method", "arguments"),
    [
        ("Camera", "build", ["boardSocket"]),
        ("Camera", "requestOutput", ["size", "type", "resizeMode", "fps", "enableUndistortion"]),
        ("StereoDepth", "build", ["autoCreateCameras", "presetMode", "size", "fps"]),
        ("StereoDepth", "inputAlignTo", []),
        ("StereoDepth", "initialConfig", []),
        ("StereoDepth", "depth", []),
        ("ImageAlign", "input", []),
        ("ImageAlign", "inputAlignTo", []),
        ("ImageAlign", "outputAligned", []),
    ],
)
def test_depthai_nodes_accept_used_arguments(owner: str, method: str, arguments: list[str]) -> None:
    load_depthai()
    import depthai as dai

    member = getattr(getattr(dai.node, owner), method)
    signatures = [s for s in (member.__doc__ or "").splitlines() if f"{method}(self" in s]

    assert not arguments or any(all(f"{a}:" in s for a in arguments) for s in signatures)
