"""The `eyehand` command: finds the sub-command and turns errors into one line and an exit code.

The table below is all that `eyehand --help` needs: no command's module is imported before it
runs, so that help answers at once and heavy libraries load only where they are used.
"""

from __future__ import annotations

import io
import os
import sys
from importlib import import_module, metadata
from typing import TYPE_CHECKING, Any, get_args

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

COMMANDS: dict[str, tuple[str, str]] = {
    "demo": ("eyehand.apps.demo:demo", "clear a table of unknown objects with a simulated robot"),
    "perceive": (
        "eyehand.apps.perceive:perceive_command",
        "describe a depth frame, a recording or a live camera",
    ),
    "fit": ("eyehand.apps.fit:fit_command", "fit the simplest solid to point clouds and meshes"),
    "synth": ("eyehand.apps.synth:synth", "make a synthetic tabletop frame with its ground truth"),
    "evaluate": (
        "eyehand.apps.grasp.bench.evaluate:evaluate_grasp",
        "clear simulated tables of unknown objects: success, cleared, times",
    ),
    "evaluate fit": (
        "eyehand.apps.fitting.bench.evaluate:evaluate_fit",
        "fit clouds with known solids and print how much of them is met",
    ),
    "evaluate segmentation": (
        "eyehand.apps.segmentation.evaluate:evaluate_segmentation",
        "score the segmentation on labelled or synthetic frames",
    ),
    "chart fit": (
        "eyehand.apps.fitting.bench.chart:chart_fit",
        "chart the fit's time against its accuracy, beside other fitters",
    ),
    "chart segmentation": (
        "eyehand.apps.segmentation.chart:chart_segmentation",
        "chart the segmentation's time against its accuracy, beside other methods",
    ),
    "chart grasp": (
        "eyehand.apps.grasp.bench.chart:chart_grasp",
        "chart the time per pick against its success, dial by dial",
    ),
    "control fig1": (
        "eyehand.apps.motion.fig1:control_fig1",
        "draw how a hand's way bends around obstacles, by the weight of avoidance",
    ),
    "control bench": (
        "eyehand.apps.motion.evaluate:control_bench",
        "run cluttered reaching scenes and print who reaches, touches, gets stuck",
    ),
    "control stress": (
        "eyehand.apps.motion.stress:control_stress",
        "make an arm's motions harder until its control breaks, and chart where",
    ),
    "touch features": (
        "eyehand.apps.touch.features:touch_features",
        "chart ways to a contact's direction and place, accuracy against time",
    ),
    "touch cop": (
        "eyehand.apps.touch.cop:touch_cop",
        "lead a thin probe between tactels: felt place against real",
    ),
    "touch track": (
        "eyehand.apps.touch.track:touch_track",
        "hold a contact's place and pressure on hard and soft objects: the paper's Table 1",
    ),
    "touch roll": (
        "eyehand.apps.touch.roll:touch_roll",
        "roll a tilted pad flat onto a face, and after the face when it turns",
    ),
    "touch edge": (
        "eyehand.apps.touch.edge:touch_edge",
        "turn the pad with an object's edge, simulated on an arm",
    ),
    "touch cable": (
        "eyehand.apps.touch.cable:touch_cable",
        "follow cables of unknown shape along a table, slowly and fast",
    ),
    "touch seek": (
        "eyehand.apps.touch.seek:touch_seek",
        "find ridges, edges and corners of unknown objects, and go round them",
    ),
    "touch stress": (
        "eyehand.apps.touch.stress:touch_stress",
        "make touching harder until the servo breaks, and chart where",
    ),
    "touch explore": (
        "eyehand.apps.touch.explore:touch_explore",
        "scan an unknown object with two pads on two arms, and write its felt cloud",
    ),
    "stress fit": (
        "eyehand.apps.fitting.bench.stress:stress_fit",
        "make clouds harder until the fit breaks, and chart where",
    ),
    "stress segmentation": (
        "eyehand.apps.segmentation.stress:stress_segmentation",
        "make staged scenes harder until the segmentation breaks, and chart where",
    ),
    "stress grasp": (
        "eyehand.apps.grasp.bench.stress:stress_grasp",
        "make picks harder until they break, and chart where",
    ),
}
"""Command name → (where it is, what it does); the first of two words names a group, and a group's
name by itself is what runs without a second word."""

ALIASES: dict[str, str] = {"evaluate grasp": "evaluate"}
"""Further name → command: every stage is evaluated, charted and stressed by its name."""

GROUPS: dict[str, str] = {
    "evaluate": "measure how good picking, or a stage of it, is, with known truth",
    "chart": "chart a stage's speed against its accuracy, dial by dial",
    "control": "move an arm among obstacles: the paper's figure, reaching, stress",
    "touch": "feel: the features of a contact, and servoing by them",
    "stress": "make a stage's task harder until it breaks, and chart where",
}
"""First words of commands that have two."""

ABOUT = "eyehand: grasp objects never seen before, from one depth image and from touch."


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave with exit code 0 (done), 1 (failed) or 2 (wrong input)."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if not arguments or arguments in (["--help"], ["-h"]):
        print(_help())
        sys.exit(0)
    if arguments == ["--version"]:
        print(metadata.version("eyehand"))
        sys.exit(0)
    # Tables hold letters that not every terminal's encoding has.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    # Small matrices gain nothing from BLAS threads, and lose much where cores are shared.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(_run(arguments))


def _run(arguments: list[str]) -> int:
    import logging

    from cyclopts import App, CycloptsError

    from eyehand.errors import EyehandError

    logging.basicConfig(format="eyehand: %(message)s", level=logging.WARNING)
    logging.getLogger("eyehand").setLevel(logging.INFO)
    app = App(
        name="eyehand",
        help=ABOUT,
        help_format="plaintext",
        version=_version,
        config=_refuse_fractions,
    )
    groups: dict[str, App] = {}
    for name in GROUPS:
        groups[name] = App(name=name, help=GROUPS[name])
        app.command(groups[name])
    entries = COMMANDS | {alias: COMMANDS[name] for alias, name in ALIASES.items()}
    for name, (where, what) in entries.items():
        *group, last = name.split()
        if name in GROUPS:
            # A default's options are the group's own: it cannot wait until it is run.
            if arguments[0] == name:
                groups[name].default(_loaded(where))
            continue
        parent = groups[group[0]] if group else app
        parent.command(where, name=last, help=what)
    app.register_install_completion_command()
    try:
        code = app(arguments, result_action="return_value", exit_on_error=False, print_error=False)
    except CycloptsError as error:
        print(
            f"eyehand: {_one_line(error)}; see eyehand {_command(arguments)}--help", file=sys.stderr
        )
        return 2
    except EyehandError as error:
        print(f"eyehand: {error}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        # The reader went away (`| head`): there is nobody left to tell.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except KeyboardInterrupt:
        print("eyehand: interrupted", file=sys.stderr)
        return 130
    return code if isinstance(code, int) else 0


def _refuse_fractions(_app: Any, _commands: tuple[str, ...], arguments: Any) -> None:
    """Refuse 1.5 where a whole number is asked for, which cyclopts would round."""
    from eyehand.errors import InputError

    for argument in arguments:
        kinds = set(_kinds(argument.hint))
        if int not in kinds or kinds & {float, str}:
            continue
        for token in argument.tokens:
            if "." in token.value and _is_fraction(token.value):
                name = token.keyword or argument.name
                raise InputError(f"{name} must be a whole number, got {token.value}")


def _kinds(hint: Any) -> Iterator[Any]:
    """All types that a hint is made of."""
    inner = get_args(hint)
    if not inner:
        yield hint
    for part in inner:
        yield from _kinds(part)


def _is_fraction(text: str) -> bool:
    try:
        return not float(text).is_integer()
    except ValueError:
        return False


def _loaded(where: str) -> Callable[..., int]:
    module, _, function = where.partition(":")
    return getattr(import_module(module), function)


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
