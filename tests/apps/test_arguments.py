"""What the command line makes of names and numbers, before any command runs."""

import pytest

from eyehand.apps.fitting.page_server import MOST_PORT, open_server
from eyehand.apps.main import main
from eyehand.errors import InputError


def told(capsys, *arguments: str) -> tuple[int, str]:
    """Exit code and stderr of a command."""
    with pytest.raises(SystemExit) as leaving:
        main(list(arguments))
    return int(leaving.value.code or 0), capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("demo", "--seed", "1.5"), "--seed"),
        (("demo", "--objects=2.5"), "--objects"),
        (("evaluate", "--scenes", "1.5"), "--scenes"),
        (("chart", "grasp", "--count", "1.5"), "--count"),
        (("stress", "grasp", "--seeds", "1.5"), "--seeds"),
    ],
)
def test_a_fraction_is_no_whole_number(capsys, arguments, name):
    code, err = told(capsys, *arguments)
    assert code == 2
    assert f"{name} must be a whole number, got " in err
    assert len(err.splitlines()) == 1


def test_whole_numbers_and_fractions_pass_where_they_belong(capsys):
    _, err = told(capsys, "evaluate", "--count", "3.0", "--friction", "0.5", "--scenes", "0")
    assert "--scenes must be >= 1, got 0" in err


def test_a_demo_ends_after_one_failure_at_the_soonest(capsys):
    code, err = told(capsys, "demo", "--failures", "0")
    assert (code, err) == (2, "eyehand: --failures must be >= 1, got 0\n")


def test_a_stage_is_evaluated_by_its_name_too(capsys):
    assert told(capsys, "evaluate", "grasp", "--scenes", "0") == told(
        capsys, "evaluate", "--scenes", "0"
    )
    with pytest.raises(SystemExit) as leaving:
        main(["evaluate", "grasp", "--help"])
    assert not leaving.value.code
    assert "--friction" in capsys.readouterr().out


@pytest.mark.parametrize("port", [-1, MOST_PORT + 1, 99999999])
def test_a_port_that_cannot_be_is_refused(port):
    with pytest.raises(InputError, match=f"from 0 to 65535, got {port}"):
        open_server(port)
