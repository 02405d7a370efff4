"""Mutated files and options of all formats: a result or one line, never a traceback or a hang.

`make test` runs a sample of the mutations, `make test-slow` more than a thousand.
"""

import importlib.util
import io
import json
import pickle
import resource
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from eyehand.apps.main import main
from eyehand.apps.mesh_file import mesh_bytes
from eyehand.data_synth import LBR_ARM
from eyehand.perception import CameraIntrinsics, DepthFrame, write_cloud, write_frame
from eyehand.perception.cameras import RosWriter, ros_header, write_ros_frames

HAS_BAGS = importlib.util.find_spec("mcap_ros2") is not None
"""Whether the extra [ros] is installed. Without it no bags are read."""

SAMPLE, ALL = 100, 1100
"""Number of mutations in the fast and in the slow test."""
BATCH = 50
"""Mutations per test."""
MAX_CPU_S, MAX_GROWTH_KB = 10.0, 1_000_000
"""Limits of one command: processor time, and growth of the peak resident set of this process."""
DESCRIPTIONS = Path(__file__).parents[2] / "grasping" / "hands" / "descriptions"
REGION = ("x_offset", "y_offset", "height", "width", "do_rectify")
"""Fields of sensor_msgs/RegionOfInterest."""
HTML = "<img src=x onerror=alert(1)>"
WORDS = [
    *("nan", "inf", "-inf", "1e308", "-1e308", "1e400", "-1", "0", "9" * 30, "0x10", "1,5", "٣"),
    *("", " ", "null", "true", "[]", "{}", '"', HTML, "../../etc/passwd", "a" * 300, "é\u202e"),
]
"""Texts in place of a number or a name."""

COMMANDS = {
    "frame.png": "perceive frame.png --out out",
    "camera.json": "perceive frame.png --camera camera.json --out out",
    "frame.npz": "perceive frame.npz --out out",
    "organised.pcd": "perceive organised.pcd --out out",
    "look.mcap": "perceive look.mcap --frames 1 --out out",
    "mask.png": "perceive frame.npz --mask mask.png --out out",
    "hand.json": "grasp frame.npz --hand hand.json --page hand.html",
    "cloud.ply": "fit cloud.ply --page fit.html",
    "text.ply": "fit text.ply --out out",
    "cloud.pcd": "fit cloud.pcd --out out",
    "cloud.xyz": "fit cloud.xyz --out out",
    "cloud.npz": "fit cloud.npz --out out",
    "mesh.stl": "fit mesh.stl --out out",
    "mesh.obj": "fit mesh.obj --out out",
    "poses.json": "calibrate poses.json --camera camera.json --out out",
    "arm.xml": "hand describe arm.xml --output described.json",
}
"""File that is mutated → command that reads it."""
if not HAS_BAGS:
    del COMMANDS["look.mcap"]
OPTIONS = {
    "perceive frame.npz --out out": ["--camera", "--mask", "--purpose", "--frames", "--record"],
    "grasp frame.npz --hand panda": [
        *("--hand", "--friction", "--calibration-error", "--top", "--table-height", "--mask"),
        *("--yaml", "--picture", "--page", "--opening", "--frames"),
    ],
    "fit cloud.ply": [
        *("--label", "--kind", "--noise-mm", "--budget-ms", "--max-parts", "--points"),
        *("--optimiser", "--mesh", "--density", "--port", "--page", "--plane", "--view-origin"),
    ],
    "calibrate poses.json": ["--camera", "--camera-on", "--squares", "--square-mm", "--board"],
    "hand describe arm.xml": ["--output", "--picture", "--name", "--tcp", "--range", "--force"],
    "synth --out out": ["--seed", "--objects", "--family", "--sensor"],
}
"""Command → options that get every word of `WORDS` in turn."""


@pytest.fixture(scope="module")
def originals(tmp_path_factory) -> Path:
    """Return a folder with a small valid file of each format."""
    folder = tmp_path_factory.mktemp("originals")
    rng = np.random.default_rng(0)
    camera = CameraIntrinsics(130.0, 130.0, 79.5, 59.5, 160, 120)
    rows, columns = np.mgrid[:120, :160]
    depth = 0.8 - 0.001 * rows + 0.0005 * rng.standard_normal((120, 160))
    depth[np.hypot(rows - 60, columns - 80) < 18] -= 0.06
    frame = DepthFrame(depth.astype(np.float32), camera)
    for name in ("frame.png", "frame.npz", "organised.pcd"):
        write_frame(folder / name, frame)
    shutil.move(folder / "frame.json", folder / "camera.json")
    shutil.copy(folder / "frame.png", folder / "mask.png")
    if HAS_BAGS:
        write_ros_frames(folder / "look.mcap", [frame])
    shutil.copy(DESCRIPTIONS / "panda.json", folder / "hand.json")
    shutil.copy(LBR_ARM, folder / "arm.xml")
    ball = rng.normal(size=(300, 3))
    ball *= 0.04 / np.linalg.norm(ball, axis=1, keepdims=True)
    for name in ("cloud.ply", "cloud.pcd", "cloud.xyz"):
        write_cloud(folder / name, ball)
    np.savez(folder / "cloud.npz", points=ball)
    table = "\n".join(" ".join(f"{value:.5f}" for value in point) for point in ball)
    head = "ply\nformat ascii 1.0\nelement vertex 300\n" + "".join(
        f"property float {axis}\n" for axis in "xyz"
    )
    (folder / "text.ply").write_text(f"{head}end_header\n{table}\n")
    corners = 0.03 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    for suffix in ("stl", "obj"):
        (folder / f"mesh.{suffix}").write_bytes(mesh_bytes(corners, faces, suffix))
    pose = {"quat_wxyz": [1, 0, 0, 0], "translation_m": [0, 0, 0.5]}
    (folder / "poses.json").write_text(json.dumps({f"{HTML}.png": pose, "../frame.png": pose}))
    return folder


def mutated(data: bytes, name: str, rng: np.random.Generator) -> bytes:
    """Return a changed copy of a file's content."""
    kind = rng.integers(8)
    at, to = sorted(int(place) for place in rng.integers(0, len(data) + 1, 2))
    if kind == 0:
        return data[:at]
    if kind == 1:
        changed = bytearray(data)
        for place in rng.integers(0, len(data), rng.integers(1, 9)):
            changed[place] = rng.integers(256)
        return bytes(changed)
    if kind == 2:
        return data[:at] + data[to:]
    if kind == 3:
        return data[:at] + data[at:to][:5000] * int(rng.integers(2, 5)) + data[to:]
    if kind == 4:
        return data[:at] + rng.bytes(int(rng.integers(1, 40))) + data[at:]
    if name.endswith(".npz"):
        return odd_archive(rng)
    if name.endswith(".mcap"):
        return odd_bag(rng)
    word = WORDS[rng.integers(len(WORDS))].encode()
    pieces = data.split(b" ") if kind == 5 else data.split(b'"') if kind == 6 else data.split(b":")
    pieces[rng.integers(len(pieces))] = word
    return (b" " if kind == 5 else b'"' if kind == 6 else b":").join(pieces)


def odd_archive(rng: np.random.Generator) -> bytes:
    """Return an archive whose arrays have unusual types, shapes or values."""
    odd = [
        np.array([{"a": 1}], dtype=object),
        np.frombuffer(pickle.dumps(print), np.uint8),
        np.zeros((0, 3)),
        np.full((120, 160), 1e308),
        np.full((300, 3), -1e308),
        np.zeros((2, 2, 2, 2)),
        np.array("<b>"),
        np.full((120, 160), np.nan),
        np.full((300, 3), 1j),
        np.full((120, 160), True),
        np.zeros((120, 160), "datetime64[s]"),
        np.full((120, 160), 2**63, np.uint64),
    ]
    names = ("depth", "points", "intrinsics", "K", "colour", "T_world_camera", "depth_scale_m")
    file = io.BytesIO()
    np.savez(file, **{one: odd[rng.integers(len(odd))] for one in names if rng.random() < 0.6})
    return file.getvalue()


def odd_bag(rng: np.random.Generator) -> bytes:
    """Return a whole recording, with right checksums, in which one field of a message is odd."""
    image = {"height": 4, "width": 6, "encoding": "32FC1", "is_bigendian": 0, "step": 24}
    image["data"] = bytes(96)
    camera = {"height": 4, "width": 6, "distortion_model": "plumb_bob", "d": [0.0] * 5}
    camera |= {"k": [5.0, 0, 3, 0, 5, 2, 0, 0, 1], "r": np.eye(3).ravel().tolist(), "p": [0.0] * 12}
    camera |= {"binning_x": 0, "binning_y": 0, "roi": dict.fromkeys(REGION, 0)}
    odd: list[tuple[dict[str, object], str, object]] = [
        *((image, side, value) for side in ("height", "width", "step") for value in (0, 2**32 - 1)),
        *((image, "encoding", value) for value in ("", "16UC1", "mono8", HTML, "é" * 300)),
        *((image, "data", value) for value in (b"", bytes(95), b"\xff" * 96)),
        *((camera, side, value) for side in ("height", "width") for value in (0, 2**32 - 1)),
        *((camera, "k", [value] * 9) for value in (0.0, -1.0, 1e308, float("nan"))),
        *((camera, "d", value) for value in ([], [1e308] * 5, [0.0] * 300)),
        *((camera, "distortion_model", value) for value in ("", HTML)),
        *((camera, "binning_x", value) for value in (7, 2**32 - 1)),
    ]
    message, field, value = odd[rng.integers(len(odd))]
    message[field] = value
    file = io.BytesIO()
    from mcap_ros2.writer import Writer

    writer = Writer(file)
    bag = RosWriter(writer)
    for seconds in (0.0, 0.1):
        head = {"header": ros_header(seconds, "../camera")}
        bag.write("/camera/camera_info", "sensor_msgs/CameraInfo", head | camera, seconds)
        bag.write("/camera/depth", "sensor_msgs/Image", head | image, seconds)
    writer.finish()
    return file.getvalue()


def check_run(words: list[str], capsys: pytest.CaptureFixture[str], about: str) -> None:
    """Run a command. It must end with a result, or with one line, within its limits."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = time.process_time()
    with pytest.raises(SystemExit) as exit_info:
        main(words)
    printed = capsys.readouterr()
    assert exit_info.value.code in (0, 1, 2), about
    assert "Traceback" not in printed.err, about
    if exit_info.value.code == 2:
        refusals = [line for line in printed.err.splitlines() if line.startswith("eyehand: ")]
        assert len(refusals) >= 1, about
    for report in Path().glob("*.html"):
        assert HTML not in report.read_text(), about
        report.unlink()
    assert time.process_time() - began < MAX_CPU_S, about
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak < MAX_GROWTH_KB, about


def check_files(seeds: range, originals: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Mutate one file per seed, and run the command that reads it."""
    for file in originals.iterdir():
        shutil.copy(file, file.name)
    for seed in seeds:
        rng = np.random.default_rng(seed)
        name = list(COMMANDS)[seed % len(COMMANDS)]
        content = (originals / name).read_bytes()
        Path(name).write_bytes(mutated(content, name, rng))
        check_run(COMMANDS[name].split(), capsys, f"seed {seed}: {name}")
        Path(name).write_bytes(content)


@pytest.fixture(scope="module")
def accepted(originals, tmp_path_factory) -> dict[str, object]:
    """Return the exit codes for the original files. It also compiles the kernels."""
    folder = shutil.copytree(originals, tmp_path_factory.mktemp("accepted"), dirs_exist_ok=True)
    names = {"frame.png", "frame.npz", "organised.pcd", "look.mcap", "cloud.ply", "mesh.obj"}
    codes = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name in sorted(names & COMMANDS.keys()):
            with pytest.raises(SystemExit) as exit_info:
                main(COMMANDS[name].split())
            codes[name] = exit_info.value.code
    return codes


@pytest.fixture(autouse=True)
def deep_folder(tmp_path, monkeypatch) -> None:
    """Work in a folder that contains what a name with `../..` reaches."""
    (tmp_path / "a" / "b").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "a" / "b")


def test_original_files_are_accepted(accepted):
    assert all(code == 0 for code in accepted.values()), accepted


@pytest.mark.usefixtures("accepted")
def test_sample_of_mutated_files(originals, capsys):
    check_files(range(SAMPLE), originals, capsys)


@pytest.mark.slow
@pytest.mark.usefixtures("accepted")
@pytest.mark.parametrize("first", range(SAMPLE, ALL, BATCH))
def test_mutated_files(first, originals, capsys):
    check_files(range(first, first + BATCH), originals, capsys)


@pytest.mark.slow
@pytest.mark.usefixtures("accepted")
@pytest.mark.parametrize("command", OPTIONS)
def test_options_with_any_text(command, originals, capsys):
    for file in originals.iterdir():
        shutil.copy(file, file.name)
    for option in OPTIONS[command]:
        for word in WORDS:
            check_run([*command.split(), option, word], capsys, f"{option} {word!r}")


def test_names_with_markup_are_escaped_in_pages(originals, capsys):
    cloud = f"{HTML.replace('/', '')}.ply"
    shutil.copy(originals / "cloud.ply", cloud)
    shutil.copy(originals / "frame.npz", "frame.npz")
    hand = json.loads((originals / "hand.json").read_text())
    Path("hand.json").write_text(json.dumps({**hand, "name": HTML}))
    for words in (["fit", cloud, "--page", "p.html"], COMMANDS["hand.json"].split()):
        check_run(words, capsys, str(words))


@pytest.mark.skipif(not HAS_BAGS, reason="bags need the extra [ros]")
def test_bags_with_odd_messages(originals, capsys):
    for seed in range(30):
        Path("look.mcap").write_bytes(odd_bag(np.random.default_rng(seed)))
        check_run(COMMANDS["look.mcap"].split(), capsys, f"odd bag {seed}")
