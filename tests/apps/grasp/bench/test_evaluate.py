"""The commands `eyehand evaluate grasp` and `eyehand chart grasp` on made-up trials."""

from __future__ import annotations

import json
import re
import shlex
from functools import partial
from typing import Any

import cv2
import pytest

from eyehand.apps.bench.shares import wilson_interval
from eyehand.apps.grasp.bench import chart as chart_grasp
from eyehand.apps.grasp.bench import conditions as grasp_plan
from eyehand.apps.grasp.bench import evaluate as evaluate_grasp
from eyehand.apps.grasp.bench import run_inputs as grasp_inputs
from eyehand.apps.grasp.bench import stored_run
from eyehand.apps.grasp.bench.conditions import (
    default_conditions,
    requested_conditions,
    source_digest,
)
from eyehand.apps.grasp.bench.jobs import Condition, SceneOutcome, attempt, scene_jobs
from eyehand.apps.grasp.bench.row_store import scene_records
from eyehand.apps.grasp.bench.summary import (
    outcome_counts,
    prototype_rows,
    rerun_command,
    summary_rows,
    worst_scenes,
)
from eyehand.apps.grasp.bench.summary_table import table_cells
from eyehand.errors import InputError

from ....browser import check_page
from ...command_line import check_refusal, run_command


@pytest.fixture
def run(made_up, monkeypatch, capsys):
    """Return a function that runs a command: exit code, stdout, stderr."""
    monkeypatch.setattr(evaluate_grasp, "run_grasp_trial", made_up.run_made_up)
    monkeypatch.setattr(chart_grasp, "run_grasp_trial", made_up.run_made_up)
    # The code may change while tests run.
    for module in (evaluate_grasp, grasp_inputs):
        monkeypatch.setattr(module, "source_digest", lambda: "the same")
    return partial(run_command, capsys=capsys)


def records(made_up, conditions, seeds=range(4)):
    """Return the records of made-up scenes."""
    jobs = scene_jobs(conditions, seeds, 3, {"purpose": "lift"})
    return [
        row for job in jobs for row in scene_records(job, attempt(made_up.run_made_up, job.trial))
    ]


def write_crate(path, width):
    """Write the mesh of a box of this width, m, that is half as high."""
    corners = [f"v {x} {y} {z}" for x in (0, width) for y in (0, width) for z in (0, 0.5 * width)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [f"f {a + 1} {b + 1} {c + 1} {d + 1}" for a, b, c, d in quads]
    path.write_text("\n".join([*corners, *faces]) + "\n")


def test_default_run_has_seven_rows_and_writes_files(run, tmp_path):
    code, out, err = run(
        "evaluate", "grasp", "--scenes", 3, "--jobs", 2, "--out", tmp_path, "--json"
    )
    assert code == 0, err
    report = json.loads(out)
    assert (report["schema"], report["seed"]) == ("eyehand.evaluate_grasp/1", 0)
    names = [row["name"] for row in report["rows"]]
    assert names == [
        *("single", "single, known", "packed", "packed, known", "pile", "pile, known"),
        "packed, friction 0.6, shake 2 s",
    ]
    for row in report["rows"]:
        assert row["scenes"] == 3
        assert row["ci_low_pct"] <= row["success_pct"] <= row["ci_high_pct"]
        assert row["cleared_ci_low_pct"] <= row["cleared_pct"] <= row["cleared_ci_high_pct"]
        assert row["seconds_per_pick"] > 0
        assert row["plan_ms"] > 0
        if row["known"]:
            assert row["success_pct"] == row["cleared_pct"] == 100
    assert len(list((tmp_path / "rows").glob("*.json"))) == 21
    page = (tmp_path / "report.html").read_text()
    assert "packed, friction 0.6, shake 2 s" in page
    assert "&lt; 20 mm &amp; rolled" in page
    assert not re.search(r"(src|href)=['\"](?!data:)", page), "the page must not load other files"
    chart = cv2.imread(str(tmp_path / "evaluate.png"))
    assert chart is not None
    assert chart.shape[1] == 1600
    assert len((tmp_path / "evaluate.csv").read_text().splitlines()) == 8


def test_report_works_in_a_browser(run, tmp_path, browser):
    assert run("evaluate", "grasp", "--scenes", 2, "--jobs", 1, "--out", tmp_path)[0] == 0
    check_page(browser, (tmp_path / "report.html").as_uri())


def test_run_continues_and_refuses_other_options(run, tmp_path, monkeypatch, made_up):
    plain = ["evaluate", "grasp", "--family", "pile", "--no-known", "--jobs", 1, "--out", tmp_path]
    assert run(*plain, "--scenes", 2)[0] == 0
    # The new runner would fail, so no finished scene may run again.
    monkeypatch.setattr(evaluate_grasp, "run_grasp_trial", made_up.run_troubled)
    code, out, err = run(*plain, "--scenes", 2, "--json")
    assert code == 0
    assert "continuing after 2 finished scenes" in err
    assert json.loads(out)["rows"][0]["faults"] == 0
    code, _, err = run(*plain, "--scenes", 2, "--friction", "0.6")
    assert code == 2
    assert "rows: was ['pile'], is ['pile, friction 0.6']" in err
    code, out, err = run(*plain, "--scenes", 2, "--fresh", "--json")
    assert code == 0
    assert "pile, seed 1 ended with a fault: RuntimeError: the hand fell off" in err
    row = json.loads(out)["rows"][0]
    assert (row["faults"], row["outcomes"]["fault"]) == (1, 1)


def test_chart_has_default_and_front(run, tmp_path):
    code, out, err = run("chart", "grasp", "--quick", "--jobs", 1, "--out", tmp_path, "--json")
    assert code == 0, err
    report = json.loads(out)
    assert [chart_grasp.dial_name(row) for row in report["rows"]] == [
        *("default", "fast perception, fast control", "fine perception, slow control")
    ]
    assert any(row["on_front"] for row in report["rows"])
    assert all(row["pick_p50_s"] > 3 for row in report["rows"])
    assert (tmp_path / "grasp.png").stat().st_size > 10_000
    assert (tmp_path / "grasp.csv").is_file()


def test_chart_draws_objects_from_folder(run, tmp_path):
    for name in ("crate", "parcel"):
        write_crate(tmp_path / f"{name}.obj", 0.05)
    quick = ["chart", "grasp", "--quick", "--jobs", 1, "--out", tmp_path / "out", "--json"]
    chosen = ["--family", "pile", "--objects", tmp_path, "--split", "held-out"]
    code, out, err = run(*quick, *chosen)
    assert code == 0, err
    assert all("held-out objects" in row["name"] for row in json.loads(out)["rows"])
    assert json.loads((tmp_path / "out" / "options.json").read_text())["objects_dir"] == str(
        tmp_path
    )
    code, _, err = run(*quick, "--split", "held-out")
    assert (code, "--split and --density need --objects FOLDER" in err) == (2, True)
    code, _, err = run(*quick, "--objects", tmp_path / "none")
    assert (code, "no folder" in err) == (2, True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scenes", "0"], "--scenes must be >= 1, got 0"),
        (["--seed", "-1"], "--seed must be >= 0"),
        (["--seed", "10000000000000000000", "--scenes", "1"], "between -2**63 and 2**63"),
        (["--seed", str(2**63 - 1), "--scenes", "2"], "must be below 2**63"),
        (["--friction", "nan"], "--friction must lie in (0, 3], got nan"),
        (["--cluster", "rubbish"], "--cluster rubbish: not an address"),
        (["--count", "16"], "--count must be from 1 to 15"),
        (["--friction", "0"], "--friction must lie in (0, 3], got 0.0"),
        (["--shake", "-1"], "--shake must lie in [0, 60] s"),
        (["--family", "heap"], "heap"),
        (["--perception", "blurred"], "expected default, fast, fine"),
        (["--control", "wild"], "expected default, slow, fast, fixed-grip, planner"),
        (["--objects", "/no/such"], "no folder /no/such"),
        (["--robot", "/no/such.xml", "--hand-frame", "palm"], "no such file"),
        (["--hand-frame", "palm"], "go together"),
        (["--no-known", "--no-camera"], "--no-known and --no-camera exclude each other"),
        (["--jobs", "0"], "--jobs must be from 1 to"),
        (["--jobs", "1000000"], "cores, got 1000000"),
        (["--jobs", "2", "--cluster", "tcp://a:1"], "leave it out with --cluster"),
        (["fti"], "fti"),
    ],
)
def test_invalid_input_of_evaluate_prints_one_line_and_exits_2(
    run, arguments, message, tmp_path, capsys
):
    check_refusal(partial(run, "evaluate", "grasp"), arguments, message, tmp_path / "out", capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--friction", "nan"], "--friction must lie in (0, 3], got nan"),
        (["--friction", "-1"], "--friction must lie in (0, 3]"),
        (["--shake", "nan"], "--shake must lie in [0, 60] s"),
        (["--shake", "-1"], "--shake must lie in [0, 60] s"),
        (["--seed", str(2**63)], "between -2**63 and 2**63"),
        (["--scenes", "0"], "--scenes must be >= 1"),
        (["--cluster", "host"], "not an address"),
    ],
)
def test_invalid_input_of_chart_prints_one_line_and_exits_2(
    run, arguments, message, tmp_path, capsys
):
    check_refusal(partial(run, "chart", "grasp"), arguments, message, tmp_path / "out", capsys)


def test_invalid_robot_is_refused_before_run(run, tmp_path):
    (tmp_path / "bad.xml").write_text("<mujoco><worldbody>")
    options = ["--robot", tmp_path / "bad.xml", "--hand-frame", "palm", "--out", tmp_path / "out"]
    code, out, err = run("evaluate", "grasp", *options)
    assert (code, out) == (2, "")
    assert "bad.xml" in err
    assert not (tmp_path / "out").exists()


def test_too_many_meshes_are_refused_before_run(run, tmp_path):
    write_crate(tmp_path / "crate.obj", 0.2)
    options = ["--objects", tmp_path, "--family", "packed", "--count", "9", "--out", tmp_path / "o"]
    code, _, err = run("evaluate", "grasp", *options)
    assert code == 2
    assert "packed scene, seed 0: 9 objects do not fit" in err
    assert not (tmp_path / "o").exists()


def test_default_folder_depends_on_options(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    quick = ["evaluate", "grasp", "--jobs", "1", "--no-known", "--scenes", "1"]
    for more in ([], ["--family", "single"], ["--family", "single", "--count", "2"]):
        code, _, err = run(*quick, *more)
        assert (code, "continuing" in err) == (0, False), err
    names = sorted(path.name for path in (tmp_path / "out" / "evaluate_grasp").iterdir())
    assert len(names) == 3
    kinds = sorted(name.rsplit("_", 1)[0] for name in names)
    assert kinds == ["single", "single", "single-packed-pile"]
    code, _, err = run(*quick[:-1], "2", "--family", "single")
    assert code == 0
    assert "continuing after 1 finished scene" in err
    assert len(list((tmp_path / "out" / "evaluate_grasp").iterdir())) == 3


def test_missing_scenes_are_reported_and_run_again(run, tmp_path, monkeypatch):
    lost_seeds = {1}

    def lossy(jobs, run_trial, *, processes, prepare):
        for job in jobs:
            is_lost = job.trial["seed"] in lost_seeds
            yield job, SceneOutcome(lost="killed") if is_lost else attempt(run_trial, job.trial)

    plain = [
        "evaluate",
        "grasp",
        "--family",
        "pile",
        "--no-known",
        "--scenes",
        3,
        "--out",
        tmp_path,
    ]
    monkeypatch.setattr(stored_run, "run_here", lossy)
    code, out, err = run(*plain, "--json")
    (row,) = json.loads(out)["rows"]
    assert (code, row["scenes"], row["missing"], row["faults"]) == (1, 2, 1, 0)
    assert "pile, seed 1 has no outcome: killed" in err
    assert "1 of 3 scenes are missing; run the same command to try them" in err
    assert table_cells(row)[0] == "2 (1 missing)"
    lost_seeds.clear()
    code, out, err = run(*plain, "--json")
    (row,) = json.loads(out)["rows"]
    assert (code, row["scenes"], row["missing"]) == (0, 3, 0)
    lost_seeds |= {0, 1, 2}
    code, _, err = run(*plain, "--fresh")
    assert code == 1
    assert "none of 3 scenes has an outcome; run the same command to try again" in err


def test_run_exits_1_if_every_scene_ends_with_a_fault(run, tmp_path, monkeypatch):
    def broken(jobs, run_trial, *, processes, prepare):
        for job in jobs:
            yield job, SceneOutcome(fault="RuntimeError: no arm")

    monkeypatch.setattr(stored_run, "run_here", broken)
    code, _, err = run("evaluate", "grasp", "--scenes", 1, "--family", "single", "--out", tmp_path)
    assert code == 1
    assert "every scene ended with a fault, the first: RuntimeError: no arm" in err


def test_timing_note_names_number_of_processes(run, tmp_path):
    plain = [
        "evaluate",
        "grasp",
        "--scenes",
        1,
        "--family",
        "single",
        "--no-known",
        "--out",
        tmp_path,
    ]
    assert "2 parallel processes" in run(*plain, "--jobs", 2)[2]
    assert "one process" in run(*plain, "--jobs", 1)[2]
    assert "2 parallel processes" not in (tmp_path / "report.html").read_text()


def test_requested_conditions_are_all_combinations_once():
    sensors, dials = ["exact"], ("fast", "slow")
    rows = requested_conditions(
        ["pile", "single"], [1, 0.6, 1], [0, 2], [1.5], sensors, dials, camera=True, known=False
    )
    assert len(rows) == len(set(rows)) == 8
    assert {row.sensor for row in rows} == {""}
    assert {row.family for row in rows} == {"single", "pile"}
    assert {(row.perception, row.control, row.known) for row in rows} == {("fast", "slow", False)}
    assert len(default_conditions(camera=False, known=True)) == 3


def test_summary_equals_direct_counts(made_up):
    rows = records(made_up, [Condition("packed"), Condition("single", known=True)])
    packed, single = summary_rows(rows)
    picks = [r for r in rows if r["record"] == "pick" and r["row"] == "packed"]
    wins = sum(pick["success"] for pick in picks)
    low, high = wilson_interval(wins, len(picks))
    assert (packed["successes"], packed["picks"], packed["objects"]) == (wins, len(picks), 12)
    assert packed["success_pct"] == pytest.approx(100 * wins / len(picks), abs=0.05)
    assert packed["ci_low_pct"] == pytest.approx(100 * low, abs=0.05)
    assert packed["ci_high_pct"] == pytest.approx(100 * high, abs=0.05)
    assert sum(packed["outcomes"].values()) == len(picks)
    assert outcome_counts(rows)["packed"] == packed["outcomes"]
    assert (single["success_pct"], single["objects"], single["perceive_ms"]) == (100, 4, 0)
    assert sum(row["picks"] for row in prototype_rows(rows)) == packed["picks"] + single["picks"]


def test_row_with_only_faults_has_figures():
    job = scene_jobs([Condition("pile")], [0], 3, {})[0]
    rows = scene_records(job, SceneOutcome(fault="RuntimeError: no"))
    (row,) = summary_rows(rows)
    assert (row["success_pct"], row["cleared_pct"], row["faults"]) == (0, 0, 1)
    assert row["perceive_ms"] is row["seconds_per_pick"] is None
    (worst,) = worst_scenes(rows, 5)
    assert worst["why"] == "fault: RuntimeError: no"


def test_worst_scenes_are_sorted_and_repeat_by_command(made_up, run, tmp_path):
    hard = Condition("pile", 0.6, 2.0, False, "fast", "default")
    rows = records(made_up, [hard], range(40, 48))
    worst = worst_scenes(rows, 3)
    assert [s["failed"] for s in worst] == sorted((s["failed"] for s in worst), reverse=True)
    words = shlex.split(worst[0]["command"])
    assert words[0] == "eyehand"
    code, out, err = run(*words[1:-1], tmp_path, "--json")
    assert code == 0, err
    (row,) = json.loads(out)["rows"]
    assert row["name"] == hard.name
    assert row["objects"] - row["placed"] == worst[0]["objects"] - worst[0]["placed"]
    assert row["picks"] - row["successes"] == worst[0]["failed"]


def test_rerun_command_keeps_known_poses_and_files(made_up):
    (row, *_) = records(made_up, [Condition("single", known=True)])
    command = rerun_command({**row, "objects_dir": "/a b", "robot": "/r.xml", "hand_frame": "palm"})
    words = shlex.split(command)
    assert "--no-camera" in words
    assert "--count" not in words
    assert words[words.index("--objects") + 1] == "/a b"
    assert words[words.index("--hand-frame") + 1] == "palm"


def test_wrongly_reported_placement_is_misplaced(made_up):
    rows = records(made_up, [Condition("single", known=True)])
    pick = next(row for row in rows if row["record"] == "pick")
    pick["success"] = False
    (row,) = summary_rows(rows)
    assert row["outcomes"] == {"placed": 3, "misplaced": 1}
    assert worst_scenes(rows, 1)[0]["why"] == "box_1 misplaced"


def test_intended_contacts_are_summed_separately(made_up):
    rows = records(made_up, [Condition("pile"), Condition("single", known=True)])
    first, second, *_ = (row for row in rows if row["record"] == "pick")
    first.update(touched_before=1, pushed=False, touched_pushing=0)
    second.update(touched_before=0, pushed=True, touched_pushing=2)
    pile, single = summary_rows(rows)
    assert (pile["touched_before"], pile["touched_pushing"], pile["pushing_picks"]) == (1, 2, 1)
    assert table_cells(pile)[-5:-2] == ["1", "2/1", "-"]
    assert table_cells(single)[-5:-2] == ["0", "-", "-"]


def test_rerun_command_is_demo_for_demo_conditions(made_up):
    (row, *_) = records(made_up, [Condition("pile")], range(7, 8))
    assert rerun_command(row) == (
        f"eyehand demo --scene pile --seed 7 --objects 3 --failures 2 --out out/again/{row['key']}"
    )


def test_rerun_folders_are_unique(made_up):
    rows = records(made_up, [Condition("pile"), Condition("pile", 0.6), Condition("packed")])
    folders = {rerun_command(row).rsplit(" ", 1)[1] for row in rows}
    assert len(folders) == len({row["key"] for row in rows})


def test_unattempted_objects_count_as_failed(made_up):
    (job,) = scene_jobs([Condition("single")], [0], 1, {})
    left = {"object": "plate", "outcome": "refused", "reason": "too flat"}
    rows = scene_records(job, SceneOutcome({"placed": 0, "total": 1, "untried": [left]}))
    (row,) = summary_rows(rows)
    assert (row["success_pct"], row["picks"], row["attempts"]) == (0, 1, 0)
    assert row["outcomes"] == {"refused": 1}
    assert table_cells({**row})[1] == "0 (1)"
    assert worst_scenes(rows, 1)[0]["why"] == "plate refused: too flat"


def test_source_digest_follows_source_folders(tmp_path, monkeypatch):
    before = source_digest()
    monkeypatch.setattr(grasp_plan, "SOURCE_FOLDERS", ("errors",))
    assert source_digest() != before


@pytest.mark.parametrize("step", [0.5, float("nan"), 11.0])
def test_load_step_out_of_range_is_refused(step):
    dials = ("default", "default")
    with pytest.raises(InputError, match="--load-step must lie in"):
        requested_conditions(
            ["single"], [1.0], [0.0], [step], ["exact"], dials, camera=True, known=True
        )


def test_sensor_models_are_rows_and_unknown_ones_are_refused():
    def rows_of(sensors: list[str]) -> list[Condition]:
        dials = ("default", "default")
        return requested_conditions(
            ["single"], [1.0], [0.0], [1.0], sensors, dials, camera=True, known=False
        )

    rows = rows_of(["exact", "real"])
    assert [row.name for row in rows] == ["single", "single, sensor real"]
    with pytest.raises(InputError, match="--sensor best: unknown, expected exact, ideal, good"):
        rows_of(["best"])


def test_unknown_family_is_refused():
    heap: Any = ["heap"]
    dials = ("default", "default")
    with pytest.raises(InputError, match="heap"):
        requested_conditions(heap, [1.0], [0.0], [1.0], ["exact"], dials, camera=True, known=True)
