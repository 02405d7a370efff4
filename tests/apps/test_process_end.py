"""Ends of processes: a termination signal unwinds, and children do not outlive their parent."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from eyehand.apps.process_end import TERMINATED, end_with_parent, termination_unwinds

WRITER = (
    "import sys, time\n"
    "from pathlib import Path\n"
    "from eyehand.apps.process_end import termination_unwinds\n"
    "from eyehand.perception.io import atomic_write\n"
    "with termination_unwinds(), atomic_write(Path(sys.argv[1])) as temporary:\n"
    "    temporary.write_bytes(b'half a film')\n"
    "    print('writing', flush=True)\n"
    "    time.sleep(60)\n"
)
"""A program that is terminated while it writes a file."""
PARENT = (
    "import os, sys, time\n"
    "from multiprocessing import get_context\n"
    "from eyehand.apps.process_end import end_with_parent\n"
    "def child(parent):\n"
    "    end_with_parent(parent)\n"
    "    print(os.getpid(), flush=True)\n"
    "    time.sleep(60)\n"
    "if __name__ == '__main__':\n"
    "    process = get_context('fork').Process(target=child, args=(os.getpid(),))\n"
    "    process.start()\n"
    "    process.join()\n"
)
"""A program whose child computes for long."""


def test_termination_removes_temporary_files(tmp_path):
    program = [sys.executable, "-c", WRITER, str(tmp_path / "film.mp4")]
    with subprocess.Popen(program, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"writing\n"
        assert len(list(tmp_path.iterdir())) == 1
        process.terminate()
        assert process.wait(20) == TERMINATED
    assert list(tmp_path.iterdir()) == []


def test_handler_of_others_is_kept():
    calls = []
    before = signal.signal(signal.SIGTERM, lambda *_: calls.append(1))
    try:
        with termination_unwinds():
            os.kill(os.getpid(), signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert calls == [1]


def test_default_action_returns_after_the_block():
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        with termination_unwinds(), pytest.raises(SystemExit) as exit_info:
            signal.raise_signal(signal.SIGTERM)
        assert exit_info.value.code == TERMINATED
        assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="prctl is a call of Linux")
def test_child_ends_with_a_killed_parent(tmp_path):
    script = tmp_path / "program.py"
    script.write_text(PARENT)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        parent.kill()
        parent.wait()
    deadline = time.monotonic() + 10
    while _is_running(child) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not _is_running(child)


def _is_running(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False


def test_parent_that_is_gone_already_ends_the_child(monkeypatch):
    class ExitError(Exception):
        pass

    def leave(code):
        raise ExitError(code)

    monkeypatch.setattr(os, "_exit", leave)
    monkeypatch.setattr("ctypes.CDLL", lambda _: type("C", (), {"prctl": lambda *_: 0})())
    with pytest.raises(ExitError, match="1"):
        end_with_parent(-1)
