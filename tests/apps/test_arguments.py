"""Parsing of command names and numbers, before any command runs."""

import dataclasses
import importlib
import inspect
import os
import sys
import typing
from types import SimpleNamespace

import pytest

from eyehand.apps.command_table import ALIASES, COMMANDS, GROUPS, RENAMED
from eyehand.apps.fitting.page_server import MAX_PORT, open_server
from eyehand.apps.main import main
from eyehand.errors import InputError


def run(capsys, *arguments: str) -> tuple[int, str]:
    """Run a command; return exit code and stderr."""
    with pytest.raises(SystemExit) as exit_info:
        main(list(arguments))
    return int(exit_info.value.code or 0), capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("demo", "--seed", "1.5"), "--seed"),
        (("demo", "--objects=2.5"), "--objects"),
        (("evaluate", "grasp", "--scenes", "1.5"), "--scenes"),
        (("chart", "grasp", "--count", "1.5"), "--count"),
        (("stress", "grasp", "--seeds", "1.5"), "--seeds"),
    ],
)
def test_fraction_is_rejected_as_a_whole_number(capsys, arguments, name):
    code, err = run(capsys, *arguments)
    assert code == 2
    assert f"{name} must be a whole number, got " in err
    assert len(err.splitlines()) == 1


def test_whole_numbers_and_fractions_are_accepted_where_valid(capsys):
    _, err = run(
        capsys, "evaluate", "grasp", "--count", "3.0", "--friction", "0.5", "--scenes", "0"
    )
    assert "--scenes must be >= 1, got 0" in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("evaluate", "fit", "--groups", "table", "compound", "--cases", "0"), "cases must be"),
        (("evaluate", "motion", "--only", "dynamic", "slow"), "unknown method 'dynamic'"),
        (("fit", "--label", "1", "--label", "2", "gone.png"), "gone.png: no such file"),
        (("evaluate", "fit", "table"), "unexpected arguments: table; see eyehand evaluate fit"),
    ],
)
def test_an_option_takes_all_values_that_follow(capsys, arguments, words):
    assert words in run(capsys, *arguments)[1]


def path_options(command: str) -> list[str]:
    """List the options of a command that take a file or folder; "" is a positional argument."""
    module, name = COMMANDS[command][0].split(":")
    function = getattr(importlib.import_module(module), name)
    hints = typing.get_type_hints(function)
    found = []
    for parameter in inspect.signature(function).parameters.values():
        hint = hints[parameter.name]
        is_named = parameter.kind is parameter.KEYWORD_ONLY
        if "pathlib.Path" in str(hint):
            found.append(f"--{parameter.name.replace('_', '-')}" if is_named else "")
        for group in filter(dataclasses.is_dataclass, (hint, *typing.get_args(hint))):
            inner = typing.get_type_hints(group)
            names = [field.name for field in dataclasses.fields(group)]
            found += [f"--{n.replace('_', '-')}" for n in names if "pathlib.Path" in str(inner[n])]
    return found


@pytest.mark.parametrize("command", COMMANDS)
def test_every_path_option_refuses_a_fifo_a_device_and_a_long_name(command, capsys, tmp_path):
    fifo = tmp_path / "pipe.png"
    os.mkfifo(fifo)
    refused = {fifo: "it is a FIFO", "/dev/zero": "it is a socket or device"}
    refused["x" * 300] = "File name too long"
    for option in path_options(command):
        for path, message in refused.items():
            words = [str(path)] if not option else [option, str(path)]
            code, err = run(capsys, *command.split(), *words)
            assert (code, len(err.splitlines())) == (2, 1), (option, err)
            assert message in err, option


@pytest.mark.parametrize("command", ["demo", "synth", "evaluate segmentation", "stress grasp"])
def test_seed_beyond_64_bits_is_refused(command, capsys):
    option = "--seeds" if command.startswith("stress") else "--seed"
    code, err = run(capsys, *command.split(), option, str(10**30))
    assert code == 2
    assert f"{option} must be between -2**63 and 2**63, got 1{'0' * 30}" in err


def test_demo_rejects_zero_failures(capsys):
    code, err = run(capsys, "demo", "--failures", "0")
    assert (code, err) == (2, "eyehand: --failures must be >= 1, got 0\n")


@pytest.mark.parametrize(
    ("former", "present"),
    [
        (("control", "bench", "--quick"), "evaluate motion"),
        (("control", "fig1"), "experiment fig1"),
        (("control", "stress"), "stress motion"),
        (("control",), "stress motion"),
        (("touch", "track", "--quick"), "experiment track"),
        (("touch", "stress"), "stress touch"),
        (("evaluate", "--scenes", "1"), "evaluate grasp"),
        (("demo", "frame.png"), "perceive FRAME"),
        (("demo", "--look"), "perceive FRAME"),
    ],
)
def test_former_command_names_the_present_one_and_exits_with_2(capsys, former, present):
    code, err = run(capsys, *former)
    assert code == 2
    assert "' is now '" in err
    assert present in err
    assert len(err.splitlines()) == 1


def test_renamed_commands_lead_to_existing_ones():
    assert not set(RENAMED) & (set(COMMANDS) | set(ALIASES) | set(GROUPS))
    for former, present in RENAMED.items():
        if " " in former:
            assert present in COMMANDS


@pytest.mark.parametrize("command", ["stress fit", "demo", "chart grasp", "experiment fig1"])
def test_missing_extra_is_named_before_the_command_works(capsys, monkeypatch, command):
    monkeypatch.setattr("eyehand.apps.main.find_spec", lambda module: None)
    code, err = run(capsys, *command.split())
    assert code == 1
    assert err == "eyehand: this command needs matplotlib: pip install 'eyehand[view]'\n"


def test_module_missing_while_a_command_runs_names_its_extra(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "mink", None)
    monkeypatch.setitem(COMMANDS, "synth", (f"{__name__}:needs_mink", ""))
    monkeypatch.setitem(sys.modules, __name__, SimpleNamespace(needs_mink=needs_mink))
    code, err = run(capsys, "synth")
    assert code == 1
    assert err == "eyehand: this command needs mink: pip install 'eyehand[baselines]'\n"


def needs_mink() -> int:
    raise ModuleNotFoundError("No module named 'mink'", name="mink")


@pytest.mark.parametrize("alias", sorted(ALIASES))
def test_alias_runs_its_command(capsys, alias):
    assert ALIASES[alias] in COMMANDS
    with pytest.raises(SystemExit) as exit_info:
        main([*alias.split(), "--help"])
    assert not exit_info.value.code
    assert "--json" in capsys.readouterr().out


@pytest.mark.parametrize("port", [-1, MAX_PORT + 1, 99999999])
def test_invalid_port_is_rejected(port):
    with pytest.raises(InputError, match=f"from 0 to 65535, got {port}"):
        open_server(port)
