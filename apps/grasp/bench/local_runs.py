"""Scenes run side by side in processes of this machine, whatever becomes of those processes.

Each process has its own physics, kernels and renderer, is started anew (not forked: a renderer's
context does not survive that), and does one scene at a time. This is not a process pool of the
standard library because such a pool, when one process dies, cannot tell whose scene it was.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections import Counter, deque
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection, get_context
from typing import TYPE_CHECKING

from .jobs import RunTrial, SceneJob, SceneOutcome, attempt

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Sequence
    from multiprocessing.connection import Connection
    from multiprocessing.context import SpawnProcess

MOST_DEATHS = 3
"""A scene during which so many processes died is left to another run."""
LONGEST_SCENE_S = 900.0
"""A scene that takes longer hangs: a hundred times what one takes."""
START_S = 120.0
"""Longest that a process may take to start, on a machine that has much else to do."""
GOODBYE_S = 2.0
"""How long a process may take to end before it is killed."""
BEGAN = SceneOutcome(lost="under way")
"""Comes before a scene's outcome, when its time begins: a process takes a while to start."""
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
"""Set to 1 in the processes: together they fill the cores already."""


@dataclass
class _Worker:
    process: SpawnProcess
    pipe: Connection
    job: SceneJob | None = None
    deadline: float = 0.0
    """When its scene is given up, on the monotonic clock, s."""


def run_here(
    jobs: Sequence[SceneJob],
    run: RunTrial,
    *,
    processes: int,
    longest: float = LONGEST_SCENE_S,
) -> Generator[tuple[SceneJob, SceneOutcome]]:
    """Run all scenes, and give each with its outcome as it is done.

    A scene whose process died (killed from outside, say) is run again, up to three times in all.
    Leaving the loop early, by an interrupt for instance, ends all processes.

    Parameters
    ----------
    jobs
        Scenes.
    run
        Runs one; a function of a module.
    processes
        Side by side, >= 1.
    longest
        Wall time after which a scene is given up, s.
    """
    waiting, deaths = deque(jobs), Counter[str]()
    workers: list[_Worker] = []
    try:
        while waiting or any(worker.job for worker in workers):
            while waiting and len(workers) < processes:
                workers.append(_start(run))
            for worker in workers:
                if worker.job is None and waiting:
                    _hand_over(worker, waiting.popleft(), START_S + longest)
            busy = [worker for worker in workers if worker.job]
            # A pipe is ready when there is an outcome, and when its other end is gone.
            first = min(worker.deadline for worker in busy)
            pipes = [worker.pipe for worker in busy]
            ready = connection.wait(pipes, max(0.0, first - time.monotonic()))
            for worker in busy:
                job = worker.job
                late = time.monotonic() > worker.deadline
                if job is None or (worker.pipe not in ready and not late):
                    continue
                outcome = _received(worker) if worker.pipe in ready else None
                if outcome == BEGAN:
                    worker.deadline = time.monotonic() + longest
                    continue
                worker.job = None
                if outcome is None:
                    workers.remove(worker)
                    _end([worker])
                    deaths[job.key] += 1
                    code = worker.process.exitcode
                    if late:
                        outcome = SceneOutcome(lost=f"took longer than {longest:g} s")
                    elif deaths[job.key] < MOST_DEATHS:
                        waiting.appendleft(job)
                        continue
                    else:
                        outcome = SceneOutcome(
                            lost=f"its process died {MOST_DEATHS} times, exit code {code}"
                        )
                yield job, outcome
    finally:
        _end(workers)


def _start(run: RunTrial) -> _Worker:
    here, there = get_context("spawn").Pipe()
    process = get_context("spawn").Process(target=_work, args=(there, run), daemon=True)
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    with _interrupts_ignored():
        process.start()
    # With our copy of its end closed, the pipe tells when the process is gone.
    there.close()
    return _Worker(process, here)


def _hand_over(worker: _Worker, job: SceneJob, seconds: float) -> None:
    worker.job, worker.deadline = job, time.monotonic() + seconds
    # A process that is gone already shows at the next look at its pipe.
    with suppress(OSError):
        worker.pipe.send(dict(job.trial))


def _received(worker: _Worker) -> SceneOutcome | None:
    try:
        return worker.pipe.recv()
    except (EOFError, OSError):
        return None


def _end(workers: Sequence[_Worker]) -> None:
    for worker in workers:
        worker.process.terminate()
    for worker in workers:
        worker.process.join(GOODBYE_S)
        if worker.process.is_alive():
            worker.process.kill()
            worker.process.join()
        worker.pipe.close()


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Let a process that is started now leave interrupts from the keyboard to this one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)


def _work(pipe: Connection, run: RunTrial) -> None:
    """Do scenes until the other end of the pipe is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Standard output may belong to one JSON object; libraries must not speak into it.
    os.dup2(2, 1)
    with suppress(EOFError, OSError):
        while True:
            trial = pipe.recv()
            pipe.send(BEGAN)
            pipe.send(attempt(run, trial))
