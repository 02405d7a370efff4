"""A fixture that runs an experiment as a user would."""

from collections.abc import Callable

import pytest

from eyehand.apps.main import main


@pytest.fixture
def run_experiment(capsys) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs `eyehand experiment` and returns exit code, stdout, stderr."""

    def run(name: str, *arguments: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as leaving:
            main(["experiment", name, *(str(argument) for argument in arguments)])
        printed = capsys.readouterr()
        return int(leaving.value.code or 0), printed.out, printed.err

    return run
