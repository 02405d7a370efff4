"""The record of a demo, and its rows, table and report page."""

from __future__ import annotations

import json
import re
import time
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import trimesh
from rich.console import Console

from eyehand.apps.demo import write_results
from eyehand.apps.grasp.bench.trial import GraspTrial, trial_cell
from eyehand.apps.grasp.demo_report import report_html, write_report
from eyehand.apps.grasp.demo_run import run_demo
from eyehand.apps.grasp.demo_scene import DEFAULT_OBJECTS, demo_scene
from eyehand.apps.grasp.demo_table import demo_rows, demo_table, ending, task_words
from eyehand.apps.grasp.force_plot import pick_timeline
from eyehand.apps.grasp.frame_crop import crop_to_objects
from eyehand.apps.grasp.perceived_picture import perceived_picture
from eyehand.apps.grasp.score_terms import SIZE_NOTE, TERM_MEANINGS, score_html, score_legend
from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame, write_scene
from eyehand.errors import InputError
from eyehand.grasping.clearing import ClearOptions
from eyehand.grasping.report import PhaseRecord

from ...browser import check_page


class Tags(HTMLParser):
    """A parser that counts elements and lists those that are not closed in order."""

    VOID = ("meta", "link", "img", "br", "rect", "line", "polyline")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.unmatched: list[str] = []
        self.addresses: list[str] = []
        self.counts: dict[str, int] = {}

    def handle_starttag(self, tag, attrs):
        """Count an element."""
        self.counts[tag] = self.counts.get(tag, 0) + 1
        self.addresses += [value for name, value in attrs if name in ("src", "href") and value]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        """Count an empty element."""
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        """Close an element."""
        if not self.open or self.open.pop() != tag:
            self.unmatched.append(tag)


def test_record_pairs_picks_with_captures_and_calls_observers(cleared):
    record, observer = cleared
    picks = record.report.picks
    assert len(picks) >= 1
    assert record.report.observations == len(record.captures)
    assert [capture.pick for capture in record.captures if capture.pick is not None] == list(picks)
    assert [capture.row for capture in record.captures if capture.row is not None] == list(
        record.result.picks
    )
    assert observer.before == observer.after == len(picks)
    assert observer.cycles >= sum(len(pick.times) for pick in picks)
    first = record.captures[0]
    assert first.target is not None
    if any(phase.phase == "close" for phase in first.pick.phases):
        palm = first.T_world_palm.translation
        assert np.linalg.norm(palm - first.target.points.mean(axis=0)) < 0.25


def test_rows_are_json_and_table_names_each_pick(cleared):
    record, _ = cleared
    rows = demo_rows(record)
    decoded = json.loads(json.dumps(rows, allow_nan=False))
    assert [row["name"] for row in decoded] == [f"pick {k + 1}" for k in range(len(rows))]
    for row, pick in zip(decoded, record.report.picks, strict=True):
        assert row["outcome"] == pick.outcome
        assert row["task_rows"] == sum(task["rows"] for task in row["tasks"]) == pick.plan.rows
    first = record.report.picks[0].plan
    rows = sum(
        int(part.split(" x ")[0]) if " x " in part else 1 for part in task_words(first).split(" + ")
    )
    assert rows == sum(task.rows > 0 for task in first.tasks)
    console = Console(width=140, record=True, file=None, quiet=False, stderr=True)
    console.print(demo_table(record))
    text = console.export_text()
    assert record.report.picks[0].plan.name in text
    assert "1 of 1 object in the tray" in text


def test_page_is_well_formed_and_embeds_its_pictures(cleared, tmp_path):
    record, _ = cleared
    film = tmp_path / "demo.mp4"
    film.write_bytes(b"not a film")
    write_report(tmp_path / "report.html", replace(record, film=film))
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    tags = Tags()
    tags.feed(text)
    assert not tags.unmatched
    assert not tags.open
    assert tags.counts["img"] == 2 * len(record.captures)
    assert tags.counts["svg"] == len(record.report.picks)
    assert tags.counts["video"] == 1
    assert all(one.startswith(("data:", "#")) for one in tags.addresses)
    assert "http" not in re.sub(r"base64,[^\"]*", "", text)


def test_page_marks_failures_and_escapes_text(cleared):
    record, _ = cleared
    capture = next(one for one in record.captures if one.pick is not None)
    failed = PhaseRecord("lift", 0.0, 1.0, "<b>dropped</b> & gone")
    pick = replace(capture.pick, outcome="slipped", reason="<i>it</i> slipped", phases=(failed,))
    html = report_html(replace(record, captures=(replace(capture, pick=pick),)))
    assert "<i>it" not in html
    assert "<b>dropped" not in html
    assert "pill bad" in html
    assert "&lt;b&gt;dropped" in html


def test_headline_names_failed_picks_of_a_cleared_table(cleared):
    record, _ = cleared
    row = replace(record.result.picks[0], success=False)
    for success, title in ((False, "Table cleared, 1 of 1 pick failed"), (True, "Table cleared")):
        picks = (replace(row, success=success),)
        result = replace(record.result, picks=picks, placed=1, total=1)
        assert f"<h1>{title}</h1>" in report_html(replace(record, result=result))


def test_report_works_in_a_browser_and_its_headline_agrees_with_its_rows(
    cleared, browser, tmp_path
):
    record, _ = cleared
    film = tmp_path / "demo.mp4"
    film.write_bytes(b"")
    write_report(tmp_path / "report.html", replace(record, film=film))
    check_page(browser, (tmp_path / "report.html").as_uri())
    pills = browser.value("[...document.querySelectorAll('td .pill')].map(one => one.innerText)")
    title = browser.value("document.querySelector('h1').innerText")
    assert len(pills) == len(record.result.picks)
    assert title == "Table cleared"
    assert set(pills) == {"placed"}


def test_force_plot_shows_short_impacts_and_pick_without_forces(cleared):
    record, _ = cleared
    pick = next(capture.pick for capture in record.captures if capture.pick is not None)
    times = np.linspace(0.0, 8.0, 2001)
    forces = np.zeros((2001, 5))
    forces[1234, 3] = 37.0
    phases = (PhaseRecord("close", 0.0, 8.0, "done"),)
    knocked = replace(pick, times=times, forces=forces, phases=phases)
    svg = pick_timeline(knocked, ("index", "middle", "ring", "thumb"))
    curves = re.findall(r'points="([^"]+)"', svg)
    assert len(curves) == 5
    heights = [[float(one.split(",")[1]) for one in curve.split()] for curve in curves]
    assert min(heights[3]) < 80 < min(heights[0])
    without_forces = replace(pick, times=np.zeros(0), forces=np.zeros((0, 5)), phases=())
    assert "<polyline" not in pick_timeline(without_forces, ("index", "middle", "ring", "thumb"))


def test_crop_keeps_labels_and_projection(cleared):
    record, _ = cleared
    capture = record.captures[0]
    frame, scene = crop_to_objects(capture.frame, capture.scene)
    assert frame.depth.size < capture.frame.depth.size
    item = capture.target
    full = np.argwhere(capture.scene.segmentation.labels == item.label)
    cut = np.argwhere(scene.segmentation.labels == item.label)
    assert len(cut) == len(full)
    point = item.points.mean(axis=0)
    T_camera_world = capture.frame.T_world_camera.inv()
    before = capture.frame.intrinsics.project(T_camera_world.apply(point)[None])[0]
    after = frame.intrinsics.project(T_camera_world.apply(point)[None])[0]
    assert before - after == pytest.approx((full[0] - cut[0])[::-1])


def test_grasp_is_drawn_at_closing_pose(cleared):
    record, _ = cleared
    capture = record.captures[0]
    frame, scene = crop_to_objects(capture.frame, capture.scene)
    bare = perceived_picture(frame, scene)
    drawn = perceived_picture(frame, scene, capture.pick.plan, capture.T_world_palm)
    changed = np.argwhere((bare != drawn).any(axis=2))
    assert len(changed) > 200
    labels = np.argwhere(scene.segmentation.labels == capture.pick.label)
    zoom = bare.shape[1] / frame.depth.shape[1]
    assert np.linalg.norm(changed.mean(axis=0) / zoom - labels.mean(axis=0)) < 60


def test_scene_comes_from_family_or_file(tmp_path):
    first, second = (demo_scene("packed", 3, 2).objects for _ in range(2))
    assert [one.name for one in first] == [one.name for one in second]
    assert np.array_equal(first[0].colour, second[0].colour)
    made = make_scene(2, TabletopOptions(count_range=(2, 2)))
    write_scene(tmp_path, made, *render_frame(made, DepthNoise.none(), 2))
    read = demo_scene(str(tmp_path / "ground_truth.json"), 0)
    assert [one.name for one in read.objects] == [one.name for one in made.objects]
    assert len(demo_scene("packed", 0).objects) == DEFAULT_OBJECTS
    assert len(demo_scene("single", 0).objects) == len(demo_scene("single", 0, 1).objects) == 1


@pytest.mark.parametrize(
    ("scene", "objects", "message"),
    [
        ("crowded", None, "no such file"),
        ("pack", None, "did you mean packed"),
        ("pile", 16, "--objects must be 1 to 15"),
        ("single", 4, "--scene single has 1 object"),
        ("packed", Path("nowhere"), "neither a number nor a folder"),
        (".", 4, "leave --objects out"),
    ],
)
def test_invalid_scene_options_are_refused(scene, objects, message):
    with pytest.raises(InputError, match=message):
        demo_scene(scene, 0, objects)


def test_each_mesh_of_folder_is_placed_once(tmp_path):
    for number in (1, 2):
        box = trimesh.creation.box(extents=(0.04, 0.05, 0.03 * number))
        box.export(tmp_path / f"box{number}.stl")
    drawn = demo_scene("packed", 0, tmp_path)
    assert drawn.folder == str(tmp_path)
    assert sorted(one.name[:4] for one in drawn.objects) == ["box1", "box2"]
    assert f"2 objects of {tmp_path}" in drawn.source
    assert len(demo_scene("single", 0, tmp_path).objects) == 1
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError):
        demo_scene("pile", 0, tmp_path / "empty")


def test_film_time_is_reported_separately(cleared):
    record, _ = cleared
    assert record.result.cpu_seconds > 0
    without_film, with_film = ending(record), ending(replace(record, film_cpu_seconds=31.4))
    robot_time = f"{record.result.cpu_seconds:.1f} s of processor time for robot and simulation"
    assert robot_time in without_film
    assert "film" not in without_film
    assert f"{robot_time}; 31.4 s more for the film" in with_film
    page = report_html(replace(record, film_cpu_seconds=31.4))
    assert "31 s</b><span>processor time, film" in page
    assert "processor time, film" not in report_html(record)


def test_observer_time_is_excluded_from_robot_time(single):
    class Slow:
        spent = 0.0

        def on_cycle(self, cycle) -> None:
            """Do nothing."""

        def on_pick(self, choice, report) -> None:
            """Use one second of processor time."""
            began = time.process_time()
            while time.process_time() < began + 1.0:
                pass
            self.spent += time.process_time() - began

    slow = Slow()
    trial = GraspTrial(family="single", seed=1, known=True)
    built = trial_cell(single.objects, trial)
    began = time.process_time()
    record = run_demo(single.source, trial, built, [lambda *_: slow], ClearOptions(picks=1))
    whole = time.process_time() - began
    assert slow.spent >= 1.0
    assert record.result.cpu_seconds <= whole - slow.spent


def test_run_without_film_removes_only_earlier_film(cleared, tmp_path, capsys):
    record, _ = cleared
    old, others = tmp_path / "demo.mp4", tmp_path / "mine.mp4"
    picture = tmp_path / "demo.webp"
    for path in (old, picture, others):
        path.write_bytes(b"a film")
    write_results(replace(record, film=old), tmp_path, json=False)
    assert old.is_file()
    write_results(record, tmp_path, json=False)
    assert not old.exists()
    assert not picture.exists()
    assert others.is_file()
    assert str(old) not in capsys.readouterr().err.splitlines()[-1]
    old.mkdir()
    with pytest.raises(InputError, match=r"demo\.mp4"):
        write_results(record, tmp_path, json=False)


def test_wrongly_reported_placement_is_marked(cleared):
    record, _ = cleared
    capture = record.captures[0]
    assert capture.outcome == "placed"
    lost = replace(capture, row=replace(capture.row, success=False))
    assert lost.outcome == "placed (not in the tray)"
    assert not lost.succeeded
    wrong = replace(record, captures=(lost, *record.captures[1:]))
    console = Console(width=160, record=True, file=None, quiet=False, stderr=True)
    console.print(demo_table(wrong))
    assert "placed (not in the tray)" in console.export_text()
    assert report_html(wrong).count('<span class="pill bad">placed (not in the tray)</span>') == 2
    slipped = replace(lost, pick=replace(capture.pick, outcome="place_failed"))
    assert slipped.outcome == "place failed"


def test_page_explains_scores_and_sizes(cleared):
    record, _ = cleared
    terms = record.report.picks[0].plan.score.terms
    html = report_html(record)
    assert set(terms) <= set(TERM_MEANINGS)
    for term in terms:
        assert f"<b>{term}</b> {TERM_MEANINGS[term]}" in html
        assert f'<span class="term" title="{TERM_MEANINGS[term]}">{term} ' in html
    assert html.count(f'<p class="legend">{SIZE_NOTE}</p>') == 1
    assert score_html({"<i>": 0.5}) == '<span class="term" title="">&lt;i&gt; 0.50</span>'
    assert score_legend([]).endswith("0 to 1.")
