"""The film of a demo: its frames, speed, captions, side panel and camera."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from eyehand.apps.grasp import film as film_module
from eyehand.apps.grasp.bench.trial import GraspTrial, trial_cell
from eyehand.apps.grasp.film import EYE, FOCAL_WIDTHS, TARGET, Film, FilmCamera
from eyehand.apps.grasp.film import SIZE as DEFAULT_SIZE
from eyehand.apps.grasp.film_frame import METER_MAX, Caption, SidePanel, cell_size, film_frame
from eyehand.data_synth.cell import GraspCell
from eyehand.data_synth.cell.grasp_cell import WORK_AREA_M
from eyehand.data_synth.render import gl_fault
from eyehand.data_synth.scenes import look_at

SIZE = (320, 180)


@dataclass
class GreyCamera:
    """A camera whose pictures are grey."""

    closed: bool = False

    def picture(self):
        """Return a grey picture."""
        wide, high = cell_size(SIZE)
        return np.full((high, wide, 3), 128, np.uint8)

    def close(self):
        """Record the call."""
        self.closed = True


def cycle_info(time: float, phase: str):
    reading = SimpleNamespace(time=time)
    return SimpleNamespace(phase=phase, reading=reading, force=np.array([0, 4.0, 0, 9, 1]))


def test_film_has_expected_frames_and_slows_down_for_fingers(tmp_path, monkeypatch):
    monkeypatch.setattr(film_module, "END_SECONDS", 0.04)
    camera, path = GreyCamera(), tmp_path / "short.mp4"
    recorder = SimpleNamespace(frame=None)
    with Film(path, SIZE) as film:
        film.film(camera, recorder)  # pyright: ignore[reportArgumentType] - the used part only
        for step in range(160):
            phase = "lift" if step < 80 else "close"
            film.on_cycle(cycle_info(0.004 * step, phase))  # pyright: ignore[reportArgumentType] - too
        assert film.frames == 2 + 4
        assert not path.exists()
    assert camera.closed
    read = cv2.VideoCapture(str(path))
    assert int(read.get(cv2.CAP_PROP_FRAME_COUNT)) == 7
    assert read.get(cv2.CAP_PROP_FPS) == pytest.approx(25)
    fine, picture = read.read()
    assert fine
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    assert picture[-6, SIZE[0] // 2].mean() < picture[60, 300].mean() - 50
    assert list(tmp_path.iterdir()) == [path]


def test_error_leaves_no_film(tmp_path):
    def fail() -> None:
        with Film(tmp_path / "none.mp4", SIZE) as film:
            film.film(GreyCamera(), SimpleNamespace(frame=None))  # pyright: ignore[reportArgumentType]
            film.on_cycle(cycle_info(0.0, "lift"))  # pyright: ignore[reportArgumentType] - as above
            raise ValueError("stop")

    with pytest.raises(ValueError, match="stop"):
        fail()
    assert list(tmp_path.iterdir()) == []


NAMES = ("index", "middle", "ring", "thumb", "palm")


def make_frame(force, scene_picture=None, size=(960, 540), names=NAMES):
    wide, high = cell_size(size)
    caption = Caption("grip", "pick 1: box", "0 of 2 in the tray", 2.0)
    side = SidePanel(scene_picture, names, force)
    return film_frame(np.full((high, wide, 3), 200, np.uint8), caption, side, size)


def changed_columns(one, other):
    return np.flatnonzero((one != other).any(axis=(0, 2)))


@pytest.mark.parametrize("size", [(960, 540), (320, 180), (640, 640)])
@pytest.mark.parametrize("fingers", [2, 4, 12])
def test_panel_and_strip_do_not_cover_cell(size, fingers):
    wide, high = cell_size(size)
    names = [*(f"finger {k}" for k in range(fingers)), "palm"]
    scene_picture = np.full((300, 400, 3), 255, np.uint8)
    frame = make_frame(np.full(len(names), 99.0), scene_picture, size, names)
    assert frame.shape == (size[1], size[0], 3)
    assert (frame[:high, size[0] - wide :] == 200).all()
    assert (frame[:high, : size[0] - wide] == 255).all(axis=2).sum() > 500


def test_force_bars_grow_with_force_and_mark_overload():
    forces = [0.0, METER_MAX / 2, METER_MAX, 10 * METER_MAX]
    none, half, full, over = (make_frame(np.array([0.0, one, 0, 0, 0])) for one in forces)
    assert len(changed_columns(none, full)) > 1.5 * len(changed_columns(none, half))
    red = (over[..., 0] > 230) & (over[..., 1] < 120)
    assert red.sum() > 20
    assert not ((full[..., 0] > 230) & (full[..., 1] < 120)).any()
    assert changed_columns(none, over).max() < 960 - cell_size((960, 540))[0]


def test_force_meters_show_finger_names():
    other = make_frame(None, names=("thumb", "middle", "ring", "index", "palm"))
    assert (make_frame(None) != other).any()


def test_tray_text_follows_true_count(tmp_path):
    in_tray = [0]
    pick = SimpleNamespace(plan=SimpleNamespace(name="top pincer"), outcome="placed")
    recorder = SimpleNamespace(frame=None)
    with Film(tmp_path / "a.mp4", SIZE) as film:
        film.film(GreyCamera(), recorder, NAMES, lambda: f"{in_tray[0]} in")  # pyright: ignore[reportArgumentType]
        film.on_pick(None, pick)  # pyright: ignore[reportArgumentType] - the used part only
        assert film.tray_text == "0 in"
        in_tray[0] = 1
        film.on_pick(None, pick)  # pyright: ignore[reportArgumentType] - as above
        assert film.tray_text == "1 in"
        in_tray[0] = 0
    assert film.tray_text == "0 in"


def test_tray_and_work_area_are_in_view():
    cell, (wide, high) = GraspCell(), cell_size(DEFAULT_SIZE)
    signs = np.array([(a, b) for a in (-0.5, 0.5) for b in (-0.5, 0.5)])
    tray = np.column_stack([signs * cell.tray_size + cell.tray_centre[:2], np.full(4, 0.076)])
    work = np.column_stack([signs * WORK_AREA_M, np.zeros(4)])
    points = look_at(np.array(EYE), np.array(TARGET)).inv().apply(np.vstack([tray, work]))
    pixels = FOCAL_WIDTHS * wide * points[:, :2] / points[:, 2:] + [wide / 2, high / 2]
    assert (pixels > 20).all()
    assert (pixels < [wide - 20, high - 20]).all()


@pytest.mark.skipif(bool(gl_fault()), reason="no OpenGL here")
def test_film_camera_renders_cell_without_changing_model(single):
    _, robot = trial_cell(single.objects, GraspTrial(family="single"))
    before = robot.model.vis.quality.numslices
    camera = FilmCamera(robot, SIZE)
    picture = camera.picture()
    camera.close()
    assert robot.model.vis.quality.numslices == before
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    red, _, blue = picture[-40:].reshape(-1, 3).mean(axis=0)
    assert red > blue + 30  # the wood of the table
    assert picture[:60].std() > 10
