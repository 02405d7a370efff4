"""Scenes in parallel processes: each has one outcome, also when processes die."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import fields
from functools import partial

import pytest

from eyehand.apps.grasp.bench.jobs import Condition, SceneOutcome, attempt, scene_jobs
from eyehand.apps.grasp.bench.local_runs import run_here
from eyehand.apps.grasp.bench.row_store import open_rows, scene_records
from eyehand.apps.grasp.bench.run_inputs import trial_extras
from eyehand.errors import DeviceError


def jobs(seeds, folder=""):
    """Return the jobs of one single scene per seed."""
    return scene_jobs([Condition("single")], seeds, 1, {"objects_dir": str(folder)})


def test_faults_deaths_and_timeouts_stop_no_other_scene(made_up, tmp_path):
    planned = jobs(range(6), tmp_path)
    found = {}
    for job, outcome in run_here(planned, made_up.run_troubled, processes=2, timeout=1.5):
        assert job.key not in found, "counted twice"
        found[job.key] = outcome
    fine, raised, killed_once, killed, hung, last = (found[job.key] for job in planned)
    assert fine.result["total"] == last.result["total"] == 1
    assert raised.fault.startswith("RuntimeError: the hand fell off (made_up_trials.py:")
    assert not killed_once.fault
    assert not killed_once.lost
    assert (killed.fault, killed.lost) == ("", "its process died 3 times, exit code -9")
    assert (hung.fault, hung.lost) == ("", "took longer than 1.5 s")


def test_time_limit_of_a_scene_excludes_the_preparation_of_a_process(made_up):
    slow = partial(time.sleep, 2.0)
    ((_, outcome),) = run_here(
        jobs([0]), made_up.run_troubled, processes=1, timeout=1.5, prepare=slow
    )
    assert outcome.result["total"] == 1
    broken = partial(int, "no number")
    ((_, outcome),) = run_here(jobs([0]), made_up.run_troubled, processes=1, prepare=broken)
    assert outcome.result["total"] == 1, "the scenes report what is broken"


def test_closed_generator_ends_processes(made_up):
    import multiprocessing

    running = run_here(jobs([0, 4, 4]), made_up.run_troubled, processes=2)
    next(running)
    assert multiprocessing.active_children()
    running.close()
    assert not multiprocessing.active_children()


def test_keyboard_interrupt_ends_silently(made_up, tmp_path):
    program = (
        "import signal\n"
        "import made_up_trials as m\n"
        "from eyehand.apps.grasp.bench.jobs import Condition, scene_jobs\n"
        "from eyehand.apps.grasp.bench.local_runs import run_here\n"
        "if __name__ == '__main__':\n"
        # Background jobs ignore SIGINT, and their children inherit this.
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"    more = {{'objects_dir': {str(tmp_path)!r}}}\n"
        "    jobs = scene_jobs([Condition('single')], range(100), 1, more)\n"
        "    try:\n"
        "        list(run_here(jobs, m.run_slowly, processes=2))\n"
        "    except KeyboardInterrupt:\n"
        "        print('interrupted')\n"
    )
    script = tmp_path / "program.py"
    script.write_text(program)
    child = subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    notes = tmp_path.glob("*_*")
    deadline = time.monotonic() + 20
    while not any(notes) and time.monotonic() < deadline:
        time.sleep(0.05)
        notes = tmp_path.glob("*_*")

    os.killpg(child.pid, signal.SIGINT)
    out, err = child.communicate(timeout=10)
    assert (out, err, child.returncode) == ("interrupted\n", "", 0)


def test_result_that_is_not_plain_is_fault():
    outcome = attempt(lambda _: {"placed": object()}, {})
    assert outcome.fault.startswith("TypeError: a trial's result must be plain numbers and text")


@pytest.mark.parametrize("error", [MemoryError("full"), OSError("no disk"), DeviceError("no GL")])
def test_machine_failure_is_not_fault_of_scene(error):
    def run(_):
        raise error

    outcome = attempt(run, {})
    assert not outcome.fault
    assert str(error) in outcome.lost


@pytest.mark.parametrize(
    ("condition", "name"),
    [
        (Condition("packed"), "packed"),
        (Condition("pile", known=True), "pile, known"),
        (Condition("packed", 0.6, 2.0), "packed, friction 0.6, shake 2 s"),
        (Condition("pile", perception="fast"), "pile, fast perception"),
    ],
)
def test_condition_name_lists_changed_values(condition, name):
    assert condition.name == name


def test_conditions_share_seeds_and_keys_are_unique():
    rows = [Condition("single"), Condition("packed"), Condition("packed", known=True)]
    planned = scene_jobs(rows, range(5, 8), 4, {"purpose": "lift"})
    assert [job.trial["seed"] for job in planned] == [5, 5, 5, 6, 6, 6, 7, 7, 7]
    assert {job.trial["objects"] for job in planned if job.row == "single"} == {1}
    assert len({job.key for job in planned}) == len(planned)
    assert planned == scene_jobs(rows, range(5, 8), 4, {"purpose": "lift"})


def test_columns_cover_trials_and_results():
    from eyehand.apps.grasp.bench.pick_row import PickRow
    from eyehand.apps.grasp.bench.trial import GraspTrial, TrialResult
    from eyehand.apps.grasp.bench.unattempted import UnattemptedObject

    extras = trial_extras("lift", None)
    (job,) = scene_jobs([Condition("packed")], [3], 5, extras)
    fault, _ = scene_records(job, SceneOutcome(fault="no"))
    assert set(job.trial) == {field.name for field in fields(GraspTrial)} <= set(fault)
    assert GraspTrial(**job.trial).objects == 5
    names = {field.name for field in (*fields(PickRow), *fields(TrialResult))}
    names |= {field.name for field in fields(UnattemptedObject)}
    assert names - {"trial", "picks", "untried"} <= set(fault), "a fault must have every field"


def test_killed_run_continues(made_up, tmp_path):
    script = tmp_path / "program.py"
    script.write_text(
        "import made_up_trials as m\n"
        "from pathlib import Path\n"
        "from eyehand.apps.grasp.bench.stored_run import run_scenes\n"
        "from eyehand.apps.grasp.bench.run_inputs import Machines\n"
        "from eyehand.apps.grasp.bench.jobs import Condition, scene_jobs\n"
        "from eyehand.apps.grasp.bench.row_store import open_rows\n"
        f"folder = Path({str(tmp_path)!r})\n"
        "if __name__ == '__main__':\n"
        "    more = {'objects_dir': str(folder)}\n"
        "    jobs = scene_jobs([Condition('single')], range(8), 1, more)\n"
        "    run_scenes(jobs, open_rows(folder, {}), Machines(1), m.run_slowly)\n"
    )
    child = subprocess.Popen([sys.executable, script], start_new_session=True)
    deadline = time.monotonic() + 120
    while not list((tmp_path / "rows").glob("s*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    store = open_rows(tmp_path, {})
    kept = store.finished()
    assert 1 <= len(kept) < 8
    planned = jobs(range(8), tmp_path)
    ran = []

    def run(trial):
        ran.append(trial["seed"])
        return made_up.run_made_up(trial)

    for job in planned:
        if job.key not in kept:
            store.add(job, attempt(run, job.trial))
    assert {job.key for job in planned} == store.finished()
    assert len(ran) == 8 - len(kept)
    assert [r["seed"] for r in store.read(planned) if r["record"] == "scene"] == list(range(8))
