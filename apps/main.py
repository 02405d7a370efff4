"""The `eyehand` command line: find the sub-command, and turn errors into one line and an exit code.

`eyehand --help` needs only the command table. The module of a command is imported when the command
runs, so that the help is fast and heavy libraries load only where they are used.
"""

from __future__ import annotations

import errno
import io
import os
import stat
import sys
from collections.abc import Iterator
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, get_args

from .command_table import ALIASES, COMMANDS, EXTRAS, GROUPS, NEEDED, RENAMED
from .kernel_folder import ensure_kernel_folder
from .process_end import termination_unwinds
from .run_folder import release_folders

ABOUT = "eyehand: grasp unknown objects from one depth image and from touch."


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit with code 0 (done), 1 (failed) or 2 (bad input)."""
    arguments = _split_numbers(sys.argv[1:] if arguments is None else arguments)
    if not arguments or arguments in (["--help"], ["-h"]):
        print(_help())
        sys.exit(0)
    if arguments == ["--version"]:
        print(metadata.version("eyehand"))
        sys.exit(0)
    _refuse_removed_folder()
    _refuse_former_name(arguments)
    _refuse_missing_extras(arguments)
    # Some terminals cannot encode every letter of the tables.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    # Threads of BLAS do not speed up small matrices, and they slow down shared cores.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    ensure_kernel_folder()
    with termination_unwinds():
        try:
            code = _run(arguments)
        finally:
            release_folders()
    sys.exit(code)


def _split_numbers(arguments: list[str]) -> list[str]:
    """Split quoted numbers such as "-0.5 1". With a minus sign first they would be an option."""
    split: list[str] = []
    for argument in arguments:
        words = argument.replace(",", " ").split()
        is_numbers = argument.startswith("-") and all(map(is_number, words))
        split += words if is_numbers else [argument]
    return split


def _refuse_removed_folder() -> None:
    """Exit with code 2 if the current folder was removed: libraries fail there in odd ways."""
    try:
        Path.cwd()
    except FileNotFoundError:
        print("eyehand: the current folder was removed; change to another one", file=sys.stderr)
        sys.exit(2)


def _refuse_former_name(arguments: list[str]) -> None:
    """Exit with code 2 and the present name if the command was renamed."""
    for former in (" ".join(arguments[:2]), arguments[0]):
        if former in RENAMED:
            print(f"eyehand: '{former}' is now '{RENAMED[former]}'", file=sys.stderr)
            sys.exit(2)
    first = arguments[1] if len(arguments) > 1 else "--help"
    is_option = first.startswith("-")
    # The former `evaluate` took options without a stage, and the former `demo` a frame.
    if arguments[0] == "evaluate" and is_option and first not in ("--help", "-h"):
        print("eyehand: 'evaluate' is now 'evaluate grasp'", file=sys.stderr)
        sys.exit(2)
    if arguments[0] == "demo" and (not is_option or first in ("--look", "--perception-only")):
        print("eyehand: 'demo FRAME' is now 'perceive FRAME'", file=sys.stderr)
        sys.exit(2)


def _refuse_missing_extras(arguments: list[str]) -> None:
    """Exit with code 1 if the command needs an extra that is not installed."""
    if "--help" in arguments or "-h" in arguments:
        return
    modules = NEEDED.get(" ".join(arguments[:2]), NEEDED.get(arguments[0], ()))
    for module in modules:
        if find_spec(module) is None:
            print(f"eyehand: {_missing(module)}", file=sys.stderr)
            sys.exit(1)


def _missing(module: str) -> str:
    return f"this command needs {module}: pip install 'eyehand[{EXTRAS[module]}]'"


def _run(arguments: list[str]) -> int:
    import logging

    from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

    from eyehand.errors import EyehandError

    logging.basicConfig(format="eyehand: %(message)s", level=logging.WARNING)
    logging.getLogger("eyehand").setLevel(logging.INFO)
    app = App(
        name="eyehand",
        help=ABOUT,
        help_format="plaintext",
        version=_version,
        config=check_arguments,
        suppress_keyboard_interrupt=False,
        default_parameter=Parameter(consume_multiple=True, negative_iterable=()),
    )
    groups = {name: App(name=name, help=GROUPS[name]) for name in GROUPS}
    for group in groups.values():
        app.command(group)
    entries = COMMANDS | {alias: COMMANDS[name] for alias, name in ALIASES.items()}
    for name, (where, what) in entries.items():
        *group, last = name.split()
        parent = groups[group[0]] if group else app
        parent.command(where, name=last, help=what)
    app.register_install_completion_command()
    try:
        code = app(arguments, result_action="return_value", exit_on_error=False, print_error=False)
    except CycloptsError as error:
        if isinstance(error, UnusedCliTokensError):
            problem = f"unexpected arguments: {' '.join(error.unused_tokens or ())}"
        else:
            problem = _one_line(error)
        print(f"eyehand: {problem}; see eyehand {_command(arguments)}--help", file=sys.stderr)
        return 2
    except EyehandError as error:
        print(f"eyehand: {_one_line(error)}", file=sys.stderr)
        return error.exit_code
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        if module not in EXTRAS:
            raise
        print(f"eyehand: {_missing(module)}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        # The reader of the pipe has closed it, as `| head` does.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            raise
        print(f"eyehand: {error.strerror}: {error.filename}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("eyehand: interrupted", file=sys.stderr)
        return 130
    return code if isinstance(code, int) else 0


def _help() -> str:
    width = max(len(name) for name in COMMANDS)
    lines = [f"  {name:<{width}}  {what}" for name, (_, what) in COMMANDS.items()]
    return "\n".join(
        [
            ABOUT,
            "",
            "Usage: eyehand COMMAND [OPTIONS]",
            "",
            "Commands:",
            *lines,
            "",
            "eyehand COMMAND --help lists a command's options.",
        ]
    )


def _version() -> str:
    return metadata.version("eyehand")


def _command(arguments: list[str]) -> str:
    for words in (2, 1):
        name = " ".join(arguments[:words])
        if name in COMMANDS or name in GROUPS or name in ALIASES:
            return f"{name} "
    return ""


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


INTEGER_BOUND = 1 << 63
"""Integers at or above this do not fit the 64-bit columns and counters that seeds end in."""


def check_arguments(_app: Any, _commands: tuple[str, ...], arguments: Any) -> None:
    """Reject values that no command can use. The signature is that of a configuration of cyclopts.

    Checked are fractions and too large numbers for integers, and FIFOs, sockets and devices for
    files and folders: to open one could wait forever.

    Raises
    ------
    InputError
        If a value is rejected.
    """
    for argument in arguments:
        kinds = set(_kinds(argument.hint))
        for token in argument.tokens:
            name = token.keyword or argument.name
            if int in kinds and not kinds & {float, str}:
                _check_integer(name, token.value)
            if kinds & {Path, str}:
                _check_path(name, token.value, is_path=Path in kinds)


def is_number(text: str) -> bool:
    """Return whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def _check_integer(name: str, text: str) -> None:
    from eyehand.errors import InputError

    if "." in text and is_number(text) and not float(text).is_integer():
        raise InputError(f"{name} must be a whole number, got {text}")
    # A float cannot represent 2**63 - 1, so whole numbers are compared as integers.
    try:
        value = int(text)
    except ValueError:
        value = float(text) if is_number(text) else 0.0
    if abs(value) >= INTEGER_BOUND:
        raise InputError(f"{name} must be between -2**63 and 2**63, got {text}")


def _check_path(name: str, text: str, *, is_path: bool) -> None:
    """Reject a special file. A text that may be a name of another kind can have any length."""
    from eyehand.errors import InputError

    try:
        mode = Path(text).stat().st_mode
    except ValueError:
        return
    except OSError as error:
        if is_path and error.errno == errno.ENAMETOOLONG:
            raise InputError(f"{name}: {error.strerror}: {text}") from error
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        kind = "a FIFO" if stat.S_ISFIFO(mode) else "a socket or device"
        raise InputError(f"{name} {text}: it is {kind}, expected a file or folder")


def _kinds(hint: Any) -> Iterator[Any]:
    """Yield all types that a type hint consists of."""
    inner = get_args(hint)
    if not inner:
        yield hint
    for part in inner:
        yield from _kinds(part)
