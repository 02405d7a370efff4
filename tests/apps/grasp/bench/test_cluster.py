"""Scenes on a real scheduler with two workers, one of which is killed."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import pytest

from eyehand.apps.grasp.bench.cluster import _outcome, check_address, run_on_cluster
from eyehand.apps.grasp.bench.jobs import Condition, scene_jobs
from eyehand.errors import InputError

SCENES = 8
WORKER_OPTIONS = ["--nthreads", "1", "--no-nanny", "--no-dashboard"]


def start_program(program: str, *arguments: str) -> subprocess.Popen:
    """Start a program of Dask without output."""
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{program}", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@pytest.fixture
def cluster(tmp_path, made_up):
    """Return the address of a local scheduler and the processes of its two workers."""
    file = tmp_path / "scheduler.json"
    options = ["--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0"]
    options += ["--no-dashboard", "--scheduler-file", str(file)]
    programs = [start_program("dask_scheduler", *options)]
    join = ["--scheduler-file", str(file), "--local-directory", str(tmp_path), *WORKER_OPTIONS]
    programs += [start_program("dask_worker", *join) for _ in range(2)]
    try:
        deadline = time.monotonic() + 30
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(0.1)
        yield json.loads(file.read_text())["address"], programs[1:]
    finally:
        for program in programs:
            program.kill()
            program.wait()


def kill_at_work(worker: subprocess.Popen, notes: Path) -> None:
    """Kill a worker as soon as it has started another scene."""
    before = set(notes.glob(f"*_{worker.pid}_*"))
    deadline = time.monotonic() + 10
    while set(notes.glob(f"*_{worker.pid}_*")) == before and time.monotonic() < deadline:
        time.sleep(0.005)
    worker.send_signal(signal.SIGKILL)
    worker.wait()


def test_killed_worker_loses_and_repeats_no_outcome(cluster, made_up, tmp_path):
    address, workers = cluster
    notes = tmp_path / "notes"
    notes.mkdir()
    jobs = scene_jobs([Condition("single")], range(SCENES), 1, {"objects_dir": str(notes)})
    done = Counter()
    for job, outcome in run_on_cluster(jobs, made_up.run_slowly, address, connect=30):
        assert not outcome.fault
        assert not outcome.lost
        assert outcome.result["total"] == 1
        done[job.key] += 1
        if len(done) == 2:
            kill_at_work(workers[0], notes)
    assert done == Counter(job.key for job in jobs)
    ran = Counter(note.name.split("_")[0] for note in notes.iterdir())
    assert len(ran) == SCENES
    assert workers[1].poll() is None
    assert sum(ran.values()) > SCENES, "the scene of the killed worker must run again"


def test_address_without_scheduler_is_refused():
    with pytest.raises(InputError, match="no scheduler answers"):
        next(run_on_cluster([], lambda trial: trial, "tcp://127.0.0.1:9", connect=0.5))


@pytest.mark.parametrize(
    "address",
    [
        "rubbish",
        "tcp://",
        "tcp://host",
        "host:8786",
        "tcp://host:99999",
        "tcp://a b:1",
        "ftp://h:1",
    ],
)
def test_invalid_address_is_refused_without_connection(address):
    with pytest.raises(InputError, match="not an address"):
        next(run_on_cluster([], lambda trial: trial, address))


def test_valid_addresses_pass():
    for address in ("tcp://127.0.0.1:8786", "tls://host.name:1", "tcp://[::1]:8786", "ws://h:80/"):
        check_address(address)


def test_dead_worker_is_not_a_fault():
    dead = SimpleNamespace(
        exception=lambda: RuntimeError("scene ran on\n4 workers that died"),
        cancelled=lambda: False,
    )
    outcome = _outcome(dead, "tcp://host:1")
    assert (outcome.fault, outcome.lost) == ("", "RuntimeError: scene ran on 4 workers that died")


def test_missing_package_names_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'eyehand\[cluster\]'"):
        next(run_on_cluster([], lambda trial: trial, "tcp://127.0.0.1:9"))
