"""The store of rows: complete scenes, once each, of one set of options."""

from __future__ import annotations

import pytest

from eyehand.apps.grasp.bench.jobs import Condition, SceneOutcome, attempt, scene_jobs
from eyehand.apps.grasp.bench.row_store import PICK, SCENE, open_rows, scene_records
from eyehand.errors import InputError

OPTIONS = {"scenes": "any", "version": "1"}


@pytest.fixture
def jobs():
    return scene_jobs([Condition("packed"), Condition("pile")], range(3), 4, {"purpose": "lift"})


def test_stored_rows_are_read_back(tmp_path, jobs, made_up):
    store = open_rows(tmp_path, OPTIONS)
    for job in jobs:
        store.add(job, attempt(made_up.run_made_up, job.trial))
    rows = store.read(jobs)
    scenes = [row for row in rows if row["record"] == SCENE]
    picks = [row for row in rows if row["record"] == PICK]
    assert [row["key"] for row in scenes] == [job.key for job in jobs]
    assert sum(row["placed"] for row in scenes) == sum(row["success"] for row in picks)
    assert {row["purpose"] for row in rows} == {"lift"}
    assert {row["curl"] for row in picks} == {None}, "NaN must become None"
    assert {row["rows"] for row in picks} == {4}
    assert {row["touched_before"] for row in rows if row["record"] == SCENE} == {None}


def test_scene_stored_twice_counts_once(tmp_path, jobs, made_up):
    store = open_rows(tmp_path, OPTIONS)
    for _ in range(2):
        store.add(jobs[0], attempt(made_up.run_made_up, jobs[0].trial))
    assert len([row for row in store.read(jobs) if row["record"] == SCENE]) == 1


def test_fault_is_uncleared_scene_and_failed_pick(jobs):
    scene, pick = scene_records(jobs[0], SceneOutcome(fault="RuntimeError: no"))
    assert (scene["outcome"], scene["placed"], scene["total"]) == ("fault", 0, 4)
    assert (pick["outcome"], pick["success"], pick["reason"]) == (
        "fault",
        False,
        "RuntimeError: no",
    )


def test_unattempted_object_is_failed_pick(jobs):
    result = {
        "placed": 1,
        "picks": [{"pick": 0, "success": True, "outcome": "placed"}],
        "untried": [{"object": "can", "outcome": "refused", "reason": "too wide"}],
    }
    _, pick, left = scene_records(jobs[0], SceneOutcome(result))
    assert (pick["tried"], pick["success"]) == (True, True)
    assert (left["tried"], left["success"], left["pick"]) == (False, False, 1)
    assert (left["object"], left["outcome"], left["reason"]) == ("can", "refused", "too wide")
    assert left["seconds"] is None


def test_new_fields_of_a_result_are_kept(jobs):
    scene, _ = scene_records(jobs[0], SceneOutcome({"placed": 1, "picks": [{"pick": 0}], "new": 3}))
    assert scene["new"] == 3


def test_reopened_store_keeps_finished_scenes_only(tmp_path, jobs, made_up):
    store = open_rows(tmp_path, OPTIONS)
    store.add(jobs[0], attempt(made_up.run_made_up, jobs[0].trial))
    (tmp_path / "rows" / ".half.json").write_bytes(b"PAR1")
    again = open_rows(tmp_path, OPTIONS)
    assert again.finished() == {jobs[0].key}
    assert not (tmp_path / "rows" / ".half.json").exists()


def test_rows_of_other_options_are_refused_until_fresh(tmp_path, jobs, made_up):
    store = open_rows(tmp_path, OPTIONS)
    store.add(jobs[0], attempt(made_up.run_made_up, jobs[0].trial))
    with pytest.raises(InputError, match="version: was 1, is 2"):
        open_rows(tmp_path, {**OPTIONS, "version": "2"})
    assert open_rows(tmp_path, {**OPTIONS, "version": "2"}, fresh=True).finished() == set()
    assert open_rows(tmp_path, {**OPTIONS, "version": "2"}).finished() == set()


def test_unreadable_file_is_named_in_error(tmp_path, jobs):
    store = open_rows(tmp_path, OPTIONS)
    (tmp_path / "rows" / f"{jobs[0].key}.json").write_bytes(b"no rows")
    with pytest.raises(InputError, match=jobs[0].key):
        store.read(jobs)
