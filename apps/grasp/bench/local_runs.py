"""Run scenes in parallel processes of this machine, also when processes die.

Each process has its own physics, kernels and renderer, and runs one scene at a time. Processes are
spawned, because the context of a renderer does not survive a fork. The process pool of the standard
library is not used: when a process dies, it cannot report which scene it was running.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from ...process_end import end_with_parent
from .jobs import RunTrial, SceneJob, SceneOutcome, attempt

MAX_DEATHS = 3
"""Number of dead processes after which a scene is left to another run."""
SCENE_TIMEOUT_S = 900.0
"""Time limit of a scene, s, a hundred times the usual time."""
START_TIMEOUT_S = 900.0
"""Time limit for the start of a process, s. On a busy machine, kernels compile for minutes."""
STOP_TIMEOUT_S = 2.0
"""Time limit for the end of a process before it is killed, s."""
BEGAN = SceneOutcome(lost="under way")
"""Message of a process when its scene starts. The time limit of the scene begins here."""
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
"""Environment variables set to 1 in the processes, because the processes already use all cores."""


@dataclass
class _Worker:
    process: SpawnProcess
    pipe: Connection
    job: SceneJob | None = None
    deadline: float = 0.0
    """Time limit of its scene on the monotonic clock, s."""


def run_here(
    jobs: Sequence[SceneJob],
    run: RunTrial,
    *,
    processes: int,
    timeout: float = SCENE_TIMEOUT_S,
    prepare: Callable[[], object] | None = None,
) -> Generator[tuple[SceneJob, SceneOutcome]]:
    """Run all scenes and yield each with its outcome as it finishes.

    A scene whose process died runs again, at most three times in total. All processes end when the
    generator is closed.

    Parameters
    ----------
    jobs
        Scenes to run.
    run
        Function that runs a scene. It must be a module-level function.
    processes
        Maximum number of parallel processes, >= 1.
    timeout
        Time limit of a scene, s.
    prepare
        Function that each process runs before its first scene, such as the compilation of kernels.
        It must be a module-level function. The time limit of a scene does not include it.
    """
    waiting, deaths = deque(jobs), Counter[str]()
    processes = min(processes, len(jobs))
    workers: list[_Worker] = []
    try:
        while waiting or any(worker.job for worker in workers):
            while waiting and len(workers) < processes:
                workers.append(_start(run, prepare))
            for worker in workers:
                if worker.job is None and waiting:
                    _hand_over(worker, waiting.popleft(), START_TIMEOUT_S + timeout)
            busy = [worker for worker in workers if worker.job]
            # A pipe is ready if it has an outcome or if its other end is closed.
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
                    worker.deadline = time.monotonic() + timeout
                    continue
                worker.job = None
                if outcome is None:
                    workers.remove(worker)
                    _end([worker])
                    deaths[job.key] += 1
                    code = worker.process.exitcode
                    if late:
                        outcome = SceneOutcome(lost=f"took longer than {timeout:g} s")
                    elif deaths[job.key] < MAX_DEATHS:
                        waiting.appendleft(job)
                        continue
                    else:
                        outcome = SceneOutcome(
                            lost=f"its process died {MAX_DEATHS} times, exit code {code}"
                        )
                yield job, outcome
    finally:
        _end(workers)


def _start(run: RunTrial, prepare: Callable[[], object] | None) -> _Worker:
    here, there = get_context("spawn").Pipe()
    process = get_context("spawn").Process(
        target=_work, args=(there, run, prepare, os.getpid()), daemon=True
    )
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    with _interrupts_ignored():
        process.start()
    # Close our copy of the other end, so that the pipe closes with the process.
    there.close()
    return _Worker(process, here)


def _hand_over(worker: _Worker, job: SceneJob, seconds: float) -> None:
    worker.job, worker.deadline = job, time.monotonic() + seconds
    # A dead process is detected at the next read of its pipe.
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
        worker.process.join(STOP_TIMEOUT_S)
        if worker.process.is_alive():
            worker.process.kill()
            worker.process.join()
        worker.pipe.close()


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Ignore keyboard interrupts in processes that are started in this context."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)


def _work(
    pipe: Connection, run: RunTrial, prepare: Callable[[], object] | None, parent: int
) -> None:
    """Run scenes until the other end of the pipe is closed."""
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Standard output is reserved for JSON. Redirect the output of libraries.
    os.dup2(2, 1)
    if prepare is not None:
        # Each scene meets the same exception, and reports it.
        with suppress(Exception):
            prepare()
    with suppress(EOFError, OSError):
        while True:
            trial = pipe.recv()
            pipe.send(BEGAN)
            pipe.send(attempt(run, trial))
