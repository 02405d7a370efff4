"""The `eyehand` command line: find the sub-command, and turn errors into one line and an exit code.

`eyehand --help` needs only the table below. The module of a command is imported when the command
runs, so that the help is fast and heavy libraries load only where they are used.
"""

from __future__ import annotations

import errno
import io
import os
import sys
from importlib import metadata
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, get_args

if TYPE_CHECKING:
    from collections.abc import Iterator

COMMANDS: dict[str, tuple[str, str]] = {
    "demo": ("eyehand.apps.demo:demo", "clear a table of unknown objects with a simulated robot"),
    "perceive": (
        "eyehand.apps.perceive:perceive_command",
        "describe a depth frame, a recording or a live camera",
    ),
    "fit": ("eyehand.apps.fit:fit_command", "fit the simplest solid to point clouds and meshes"),
    "synth": ("eyehand.apps.synth:synth", "make a synthetic tabletop frame with its ground truth"),
    "evaluate segmentation": (
        "eyehand.apps.segmentation.evaluate:evaluate_segmentation",
        "score the segmentation on labelled or synthetic frames",
    ),
    "evaluate fit": (
        "eyehand.apps.fitting.bench.evaluate:evaluate_fit",
        "fit clouds of known solids and report the overlap",
    ),
    "evaluate motion": (
        "eyehand.apps.motion.evaluate:evaluate_motion",
        "run cluttered reaching scenes: success, contacts, time per cycle",
    ),
    "evaluate grasp": (
        "eyehand.apps.grasp.bench.evaluate:evaluate_grasp",
        "clear simulated tables of unknown objects: success, objects put away, times",
    ),
    "chart segmentation": (
        "eyehand.apps.segmentation.chart:chart_segmentation",
        "chart the segmentation's time against its accuracy, beside baselines",
    ),
    "chart fit": (
        "eyehand.apps.fitting.bench.chart:chart_fit",
        "chart the fit's time against its accuracy, beside baselines",
    ),
    "chart grasp": (
        "eyehand.apps.grasp.bench.chart:chart_grasp",
        "chart the time per pick against its success for every dial",
    ),
    "stress segmentation": (
        "eyehand.apps.segmentation.stress:stress_segmentation",
        "make staged scenes harder until the segmentation breaks, and chart where",
    ),
    "stress fit": (
        "eyehand.apps.fitting.bench.stress:stress_fit",
        "make clouds harder until the fit breaks, and chart where",
    ),
    "stress motion": (
        "eyehand.apps.motion.stress:stress_motion",
        "make motions of an arm harder until the controller breaks, and chart where",
    ),
    "stress touch": (
        "eyehand.apps.touch.stress:stress_touch",
        "make contacts harder until the tactile servo breaks, and chart where",
    ),
    "stress grasp": (
        "eyehand.apps.grasp.bench.stress:stress_grasp",
        "make picks harder until they break, and chart where",
    ),
    "experiment fig1": (
        "eyehand.apps.motion.fig1:experiment_fig1",
        "Fig. 1: the path of a hand around obstacles, by the weight of avoidance",
    ),
    "experiment features": (
        "eyehand.apps.touch.features:experiment_features",
        "section 3.2: methods for a contact's orientation and position, time against accuracy",
    ),
    "experiment cop": (
        "eyehand.apps.touch.cop:experiment_cop",
        "Fig. 5: the centre of pressure of a thin probe between tactels",
    ),
    "experiment track": (
        "eyehand.apps.touch.track:experiment_track",
        "Table 1, Fig. 8: hold a contact's position and pressure on hard and soft objects",
    ),
    "experiment roll": (
        "eyehand.apps.touch.roll:experiment_roll",
        "Fig. 9: roll a tilted pad flat onto a face, and follow the face when it turns",
    ),
    "experiment edge": (
        "eyehand.apps.touch.edge:experiment_edge",
        "section 4.3: turn the pad with an object's edge",
    ),
    "experiment cable": (
        "eyehand.apps.touch.cable:experiment_cable",
        "Fig. 10: follow cables of unknown shape along a table",
    ),
    "experiment explore": (
        "eyehand.apps.touch.explore:experiment_explore",
        "Fig. 11: scan an unknown object with two pads on two arms, and write its point cloud",
    ),
    "experiment seek": (
        "eyehand.apps.touch.seek:experiment_seek",
        "section 5: find ridges, edges and corners of unknown objects by touch",
    ),
}
"""Command name → (module:function, one-line help)."""

ALIASES: dict[str, str] = {
    "evaluate touch": "experiment track",
    "chart motion": "evaluate motion",
    "chart touch": "experiment features",
}
"""Second name → command, so that every stage can be evaluated and charted under its own name."""

GROUPS: dict[str, str] = {
    "evaluate": "measure a stage against known truth",
    "chart": "chart a stage's speed against its accuracy",
    "stress": "make a stage's task harder until it breaks, and chart where",
    "experiment": "run a figure, table or section of the chapter",
}
"""First word of a two-word command → one-line help."""

RENAMED: dict[str, str] = {
    "control fig1": "experiment fig1",
    "control bench": "evaluate motion",
    "control stress": "stress motion",
    "control": "evaluate motion, stress motion or experiment fig1",
    "touch stress": "stress touch",
    **{
        f"touch {name}": f"experiment {name}"
        for name in ("features", "cop", "track", "roll", "edge", "cable", "seek", "explore")
    },
    "touch": "experiment NAME",
}
"""Former command → what it is called now."""

EXTRAS: dict[str, str] = {
    "OpenGL": "sim",
    "pyarrow": "sim",
    "imageio_ffmpeg": "view",
    "matplotlib": "view",
    "pyvista": "view",
    "viser": "view",
    "vtkmodules": "view",
    "depthai": "oak",
    "gymnasium_robotics": "robots",
    "distributed": "cluster",
    "mink": "baselines",
    "open3d": "baselines",
}
"""Module that the core install leaves out → the extra that installs it."""

NEEDED: dict[str, tuple[str, ...]] = {
    "demo": ("matplotlib", "imageio_ffmpeg"),
    "evaluate": ("matplotlib",),
    "evaluate grasp": ("matplotlib", "pyarrow"),
    "chart": ("matplotlib",),
    "chart grasp": ("matplotlib", "pyarrow"),
    "stress": ("matplotlib",),
    "experiment": ("matplotlib",),
}
"""Command or group → modules of extras that it needs, checked before it starts to work."""

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
    _refuse_former_name(arguments)
    _refuse_missing_extras(arguments)
    # Some terminals cannot encode every letter of the tables.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    # Threads of BLAS do not speed up small matrices, and they slow down shared cores.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.exit(_run(arguments))


def _split_numbers(arguments: list[str]) -> list[str]:
    """Split quoted numbers such as "-0.5 1". With a minus sign first they would be an option."""
    split: list[str] = []
    for argument in arguments:
        words = argument.replace(",", " ").split()
        is_numbers = argument.startswith("-") and all(map(_is_number, words))
        split += words if is_numbers else [argument]
    return split


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _refuse_former_name(arguments: list[str]) -> None:
    """Exit with code 2 and the present name if the command was renamed."""
    for former in (" ".join(arguments[:2]), arguments[0]):
        if former in RENAMED:
            print(f"eyehand: '{former}' is now '{RENAMED[former]}'", file=sys.stderr)
            sys.exit(2)
    # The former `evaluate` took options without naming a stage.
    option = arguments[1] if len(arguments) > 1 else ""
    if arguments[0] == "evaluate" and option.startswith("--") and option != "--help":
        print("eyehand: 'evaluate' is now 'evaluate grasp'", file=sys.stderr)
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
        print(
            f"eyehand: {_one_line(error)}; see eyehand {_command(arguments)}--help", file=sys.stderr
        )
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


def _refuse_fractions(_app: Any, _commands: tuple[str, ...], arguments: Any) -> None:
    """Reject fractions for integer options, because cyclopts would round them."""
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
    """Yield all types that a type hint consists of."""
    inner = get_args(hint)
    if not inner:
        yield hint
    for part in inner:
        yield from _kinds(part)


def _is_fraction(text: str) -> bool:
    return _is_number(text) and not float(text).is_integer()


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
