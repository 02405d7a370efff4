"""Run a command in the process of a test."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from eyehand.apps.main import main


def run_command(*words: object, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Run a command line; return exit code, stdout and stderr."""
    with pytest.raises(SystemExit) as exit_info:
        main([str(word) for word in words])
    printed = capsys.readouterr()
    return int(exit_info.value.code or 0), printed.out, printed.err


def check_refusal(
    run: Callable[..., tuple[int, str, str]],
    arguments: Sequence[object],
    message: str,
    out: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Check that a command refuses arguments in one line with code 2, and makes no folder."""
    code, printed, error = run(*arguments, "--out", out, capsys=capsys)
    assert code == 2
    assert message in error
    assert len(error.strip().splitlines()) == 1
    assert printed == ""
    assert not out.exists()
