"""A fixture that runs an experiment as a user would."""

from collections.abc import Callable

import pytest

from ..command_line import run_command


@pytest.fixture
def run_experiment(capsys) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs `eyehand experiment` and returns exit code, stdout, stderr."""

    def run(name: str, *arguments: object) -> tuple[int, str, str]:
        return run_command("experiment", name, *arguments, capsys=capsys)

    return run
