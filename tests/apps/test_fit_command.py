"""`eyehand fit`: output, files and rejected input."""

import json
import os
import signal
import subprocess
import sys
import urllib.request
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth import import_mujoco
from eyehand.perception import Superquadric, read_cloud, write_cloud
from eyehand.perception.superquadric import PARAMETERS, sample_surface

from .command_line import run_command

SAMPLE = Path(__file__).resolve().parents[2] / "apps" / "sample" / "depth.png"
INTERRUPTIBLE = (
    "import runpy, signal\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "runpy.run_module('eyehand.apps', run_name='__main__', alter_sys=True)\n"
)
"""Program that runs a command. Background jobs ignore Ctrl-C, and their children inherit this."""


@pytest.fixture(autouse=True)
def flat(monkeypatch) -> None:
    """Disable OpenGL, which takes seconds to start."""
    monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.fixture
def ball(tmp_path) -> Path:
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(600, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return write_cloud(tmp_path / "ball.ply", [0.0, 0.0, 0.04] + 0.04 * directions)


run = partial(run_command, "fit")


def rejection(*arguments, capsys) -> str:
    """Run a rejected command; return its message, which must be one line."""
    code, out, err = run(*arguments, capsys=capsys)
    assert code == 2
    assert out == ""
    assert err.startswith("eyehand: ")
    assert len(err.strip().splitlines()) == 1
    return err


def test_fit_of_a_frame_object_writes_all_files(tmp_path, capsys):
    folder = tmp_path / "out"
    code, out, _ = run(SAMPLE, "--label", 4, "--out", folder, "--json", capsys=capsys)
    assert code == 0
    (row,) = json.loads(out)["rows"]
    assert row["converged"]
    assert row["solid"]["kind"] == "sphere"
    names = {path.name for path in folder.iterdir()}
    assert {f"depth_4_solid.{suffix}" for suffix in ("json", "png", "ply")} <= names
    assert {"depth_4_body.xml", "depth_4_body.urdf"} <= names
    model = import_mujoco().MjModel.from_xml_path(str(folder / "depth_4_body.xml"))
    assert model.body_mass[1] == pytest.approx(1000 * row["solid"]["volume_m3"], rel=0.01)


def test_json_file_has_solid_uncertainty_and_source(tmp_path, capsys):
    assert run(SAMPLE, "--label", 4, "--out", tmp_path, capsys=capsys)[0] == 0
    report = json.loads((tmp_path / "depth_4_solid.json").read_text())
    assert report["schema"] == "eyehand.solid/1"
    assert report["units"]["quaternion"] == "wxyz"
    assert np.linalg.norm(report["solid"]["quat_wxyz"]) == pytest.approx(1.0, abs=1e-4)
    assert len(report["solid"]["taper"]) == 2
    assert report["parts"][0] == report["solid"]
    covariance = np.array(report["uncertainty"]["covariance"])
    assert report["uncertainty"]["parameters"] == list(PARAMETERS)
    assert covariance.shape == (13, 13)
    assert np.all(np.linalg.eigvalsh(covariance) > -1e-9)
    assert set(report["uncertainty"]["unobserved_sides"]) <= {
        f"{sign}{axis}" for sign in "+-" for axis in "xyz"
    }
    assert [side["side"] for side in report["sides"]] == ["+x", "-x", "+y", "-y", "+z", "-z"]
    for side in report["sides"]:
        assert side["sigma_m"] > 0.0
        assert side["high_m"] is None or side["low_m"] <= side["high_m"]
    assert report["runner_up"]["kind"] != report["solid"]["kind"]
    assert report["margin"] >= 0
    assert isinstance(report["ambiguous"], bool)
    assert report["view_origin_m"] is not None
    assert report["support_plane"]["normal"][2] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("form", ["ply", "stl", "obj"])
def test_mesh_has_the_requested_format(ball, tmp_path, capsys, form):
    assert run(ball, "--out", tmp_path / "o", "--mesh", form, capsys=capsys)[0] == 0
    surface = read_cloud(tmp_path / "o" / f"ball_solid.{form}", samples=200)
    assert np.linalg.norm(surface - [0, 0, 0.04], axis=1) == pytest.approx(0.04, abs=5e-4)


@pytest.mark.parametrize(
    ("radii", "rings", "wrong"), [([0.05], 16, False), ([0.05], 8, True), ([0.05, 0.047], 8, False)]
)
def test_solid_ends_where_a_closed_mesh_ends(radii, rings, wrong, tmp_path, capsys):
    """A ball of 16 rings of triangles, its lower half as an open mesh, and as a bowl."""
    tilt, turn = np.meshgrid(np.pi * np.arange(17) / 16, 2 * np.pi * np.arange(24) / 24)
    ball = [np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), -np.cos(tilt)]
    corners = np.stack(ball, -1).transpose(1, 0, 2).reshape(-1, 3)
    lines = [f"v {x} {y} {z}" for radius in radii for x, y, z in radius * corners]
    for k in range(24 * rings):
        a, b = k + 1, k + 1 - k % 24 + (k + 1) % 24
        for first, second in ((b, b + 24), (b + 24, a + 24)):
            lines.append(f"f {a} {first} {second}")
            if len(radii) > 1:
                lines.append(f"f {a + 408} {second + 408} {first + 408}")
    file = tmp_path / "ball.obj"
    file.write_text("\n".join(lines))
    kind = ("--kind", "sphere") if len(radii) == 1 else ()
    _, out, table = run(file, *kind, "--max-parts", 1, "--json", capsys=capsys)
    (row,) = json.loads(out)["rows"]
    assert ("wrong size" in table) == wrong, table
    assert (row["beyond_mesh_mm"] > 10.0) == wrong


def test_density_sets_the_mass(ball, tmp_path, capsys):
    assert run(ball, "--out", tmp_path, "--density", 250, capsys=capsys)[0] == 0
    for suffix in (".xml", ".urdf"):
        model = import_mujoco().MjModel.from_xml_path(str(tmp_path / f"ball_body{suffix}"))
        assert model.body_mass[1] == pytest.approx(250 * 4 / 3 * np.pi * 0.04**3, rel=0.02)


def test_failed_fit_gives_a_row_and_exit_code_1_but_no_body(tmp_path, capsys):
    (tmp_path / "few.xyz").write_text("0 0 0\n0 0 1\n0 1 0\n")
    code, out, err = run(tmp_path / "few.xyz", "--out", tmp_path / "o", "--json", capsys=capsys)
    assert code == 1
    (row,) = json.loads(out)["rows"]
    assert row["solid"] is None
    assert "too few" in row["reason"]
    assert "too few" in err
    assert {path.name for path in (tmp_path / "o").iterdir()} == {"few_solid.json", "few_solid.png"}


def test_missing_file_is_rejected_before_any_output(ball, tmp_path, capsys):
    err = rejection(ball, tmp_path / "gone.ply", "--out", tmp_path / "o", capsys=capsys)
    assert "gone.ply" in err
    assert not (tmp_path / "o").exists()


def test_unusual_names_and_clouds_give_rows_and_files(tmp_path, capsys):
    rng = np.random.default_rng(0)
    solid = Superquadric(np.array([0.05, 0.03, 0.02]), (0.4, 0.7), RigidTransform.identity())
    points = sample_surface(solid, 300, rng)
    clouds = {
        "[cup] a&b": points,
        "far": points + np.array([1e4, 0.0, 0.0]),
        "mm": points * 1e3,
        "one": points[:1],
        "same": np.ones((90, 3)),
        "line": np.outer(np.linspace(0.0, 0.1, 90), [1.0, 2.0, 3.0]),
    }
    files = [write_cloud(tmp_path / f"{name}.xyz", cloud) for name, cloud in clouds.items()]
    page = tmp_path / "o" / "all.html"
    code, out, _ = run(*files, "--out", tmp_path / "o", "--page", page, "--json", capsys=capsys)
    assert code == 1
    rows = json.loads(out)["rows"]
    assert [row["converged"] for row in rows] == [True, True, False, False, False, False]
    assert all(row["converged"] or row["reason"] for row in rows)
    model = import_mujoco().MjModel.from_xml_path(str(tmp_path / "o" / "[cup] a&b_body.urdf"))
    assert model.ngeom == 1
    assert len(list((tmp_path / "o").glob("*.png"))) == len(clouds)


def test_kind_optimiser_and_points_are_options(tmp_path, capsys):
    solid = Superquadric(np.array([0.05, 0.04, 0.03]), (0.5, 0.8), RigidTransform.identity())
    cloud = write_cloud(tmp_path / "s.xyz", sample_surface(solid, 500, np.random.default_rng(0)))
    code, out, _ = run(
        cloud, "--kind", "tapered", "--optimiser", "lm", "--points", 200, "--json", capsys=capsys
    )
    assert code == 0
    assert json.loads(out)["rows"][0]["solid"]["kind"] == "tapered"


def test_page_is_one_file(ball, tmp_path, capsys):
    page = tmp_path / "new" / "ball.html"
    code, out, _ = run(ball, "--page", page, "--json", capsys=capsys)
    assert code == 0
    json.loads(out)
    assert "__VISER_EMBED_DATA__" in page.read_text()


@pytest.mark.parametrize(
    "options",
    [["{fifo}.ply"], ["{ball}", "--page", "{fifo}.html"], ["{frame}", "--mask", "{fifo}.png"]],
)
def test_fifo_is_refused_at_once_and_kept(options, ball, tmp_path, capsys):
    fifo = tmp_path / "pipe"
    named = [option.format(ball=ball, frame=SAMPLE, fifo=fifo) for option in options]
    os.mkfifo(named[-1])
    assert "FIFO" in rejection(*named, capsys=capsys)
    assert Path(named[-1]).is_fifo()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "CLOUD"),
        (["{ball}", "--label", "1"], "--label"),
        (["{frame}"], "--label from 1"),
        (["{frame}", "--label", "77"], "no object 77"),
        (["{frame}", "--label", "1", "--plane", "0", "0", "1", "0"], "has its own"),
        (["{frame}", "--label", "1", "--label", "1", "--plane", "0", "0", "0", "1"], "--plane"),
        (["{ball}", "--plane", "nan", "0", "1", "0"], "--plane"),
        (["{ball}", "--view-origin", "nan", "0", "1"], "--view-origin"),
        (["{ball}", "--view-origin", "1", "2"], "view-origin"),
        (["{ball}", "--points", "2"], "points"),
        (["{ball}", "--budget-ms", "-3"], "--budget-ms"),
        (["{ball}", "--budget-ms", "20", "--points", "100"], "--points"),
        (["{ball}", "--max-parts", "0"], "--max-parts"),
        (["{ball}", "--optimiser", "magic"], "magic"),
        (["{ball}", "--mesh", "step"], "step"),
        (["{ball}", "--density", "0"], "--density"),
        (["{ball}", "--port", "70000"], "--port"),
        (["{ball}", "--page", "page.pdf"], ".html"),
        (["{ball}", "--page", "ball.ply/page.html"], "cannot create the folder"),
        (["{ball}", "{ball}", "--out", "o"], "same name"),
        (["{folder}"], "suffix"),
    ],
)
def test_invalid_input_gives_one_line_and_no_file(
    arguments, message, ball, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    named = [argument.format(ball=ball, frame=SAMPLE, folder=tmp_path) for argument in arguments]
    assert message in rejection(*named, capsys=capsys)
    assert sorted(tmp_path.rglob("*")) == before


def test_ctrl_c_ends_the_live_page_with_exit_code_0(ball):
    command = [sys.executable, "-c", INTERRUPTIBLE, "fit", str(ball), "--view", "--json"]
    served = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=dict(os.environ)
    )
    try:
        assert served.stderr is not None
        address = next(line.split()[3] for line in served.stderr if "live page at" in line)
        with urllib.request.urlopen(address, timeout=10) as answer:
            assert answer.status == 200
        served.send_signal(signal.SIGINT)
        out, _ = served.communicate(timeout=20)
        assert served.returncode == 0
        json.loads(out)
    finally:
        served.kill()
