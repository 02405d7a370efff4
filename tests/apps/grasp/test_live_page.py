"""The live page: meshes, pause, single steps, speed, and the drawn captures."""

from __future__ import annotations

import threading
import time
import urllib.request
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from eyehand.apps.fitting.page_server import ANY_PORT, close_server, open_server
from eyehand.apps.grasp.bench.trial import GraspTrial, trial_cell
from eyehand.apps.grasp.body_meshes import body_meshes
from eyehand.apps.grasp.demo_record import Recorder
from eyehand.apps.grasp.live_page import LivePage
from eyehand.apps.grasp.live_scene import LiveScene
from eyehand.apps.scene_picture import colour_of
from eyehand.grasping.cell import CycleInfo


@pytest.fixture(scope="module")
def built_cell(single):
    return trial_cell(single.objects, GraspTrial(family="single"))


@pytest.fixture
def page(built_cell):
    cell, robot = built_cell
    with LivePage(ANY_PORT) as live:
        live.join(cell, robot, Recorder(cell))
        yield live


def cycle_info(cell, seconds: float) -> CycleInfo:
    reading = SimpleNamespace(time=cell.reading.time + seconds)
    return CycleInfo("lift", reading, None, None, np.arange(5.0))  # pyright: ignore[reportArgumentType]


def test_page_answers(page):
    with urllib.request.urlopen(page.address, timeout=5) as answer:
        assert answer.status == 200


def test_meshes_have_size_and_colour_of_bodies(built_cell):
    _, robot = built_cell
    meshes = body_meshes(robot.model)
    item = robot.world.objects[0]
    mesh = meshes[robot.model.body(item.name).id]
    assert np.sort(mesh.extents) == pytest.approx(np.sort(2 * item.shape.semi_axes), rel=0.05)
    colour = np.asarray(mesh.visual.vertex_colors)[0, :3] / 255
    assert colour == pytest.approx(item.colour, abs=0.01)
    robots = [body for body in meshes if robot.model.body(body).name.startswith("robot_")]
    assert len(robots) > 15


def test_paused_page_waits_for_step(page, built_cell):
    cell, _ = built_cell
    page.on_cycle(cycle_info(cell, 0.0))
    page.paused.value = True
    ended = threading.Event()

    def run() -> None:
        page.on_cycle(cycle_info(cell, 0.004))
        ended.set()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    assert not ended.wait(0.15)
    for callback in page.step._impl.update_cb:
        callback(None)
    assert ended.wait(2.0)
    thread.join()
    page.paused.value = False


def test_slider_sets_speed(page, built_cell):
    cell, _ = built_cell
    page.speed.value = 2.0
    page.on_cycle(cycle_info(cell, 0.0))
    began = time.perf_counter()
    for step in range(1, 51):
        page.on_cycle(cycle_info(cell, 0.008 * step))
    assert 0.17 < time.perf_counter() - began < 1.0


@pytest.fixture
def server():
    opened = open_server()
    yield opened
    close_server(opened)


def nodes(server) -> dict[str, Any]:
    """Return the nodes of the drawn capture by the ends of their names."""
    parts = {}
    for name, handle in server.scene._handle_from_node_name.items():
        if name.startswith("/capture") and name.count("/") > 1:
            parts[name.split("/", 2)[2]] = handle
    return parts


def test_removed_object_and_old_capture_leave_page(server, built_cell, cleared):
    record, _ = cleared
    capture = record.captures[0]
    label = capture.target.label
    shown = LiveScene(server.scene, built_cell[1])
    shown.show_capture(capture.frame, capture.scene, capture.pick.plan, {label: 7})
    first = nodes(server)
    assert {"grasp", "cloud0", f"cloud{label}", f"{label}/0/surface"} <= set(first)
    assert first[f"cloud{label}"].colors[0].tolist() == colour_of(7).tolist()
    assert tuple(first[f"{label}/0/surface"].color) == tuple(colour_of(7).tolist())
    shown.remove_object(label)
    left = nodes(server)
    assert "cloud0" in left
    assert not [name for name in left if name.startswith((f"{label}/0/", f"cloud{label}", "grasp"))]
    shown.remove_object(label)
    last = record.captures[-1]
    shown.show_capture(last.frame, last.scene)
    assert "grasp" not in nodes(server)
    assert nodes(server)["cloud0"] is not left["cloud0"]
    assert len({name.split("/")[1] for name in _capture_names(server)}) == 1


def _capture_names(server) -> list[str]:
    return [name for name in server.scene._handle_from_node_name if name.startswith("/capture")]


def test_last_capture_stays_after_end(page, cleared):
    record, _ = cleared
    capture, last = record.captures[0], record.captures[-1]
    page._recorder = SimpleNamespace(
        frame=capture.frame, scene=capture.scene, colours=capture.colours
    )
    choice = SimpleNamespace(target=capture.target, plan=capture.pick.plan, scene=capture.scene)
    page.on_pick(choice, None)
    assert "grasp" in nodes(page._server)
    page._recorder = SimpleNamespace(frame=last.frame, scene=last.scene, colours=last.colours)
    page.on_pick(choice, capture.pick)
    page.finish()
    left = nodes(page._server)
    assert "cloud0" in left
    assert "grasp" not in left
    assert not [name for name in left if name.endswith("/surface")] or last.scene.objects
    assert "Done" in page._status.content
