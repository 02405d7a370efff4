"""Hook of MkDocs: pages made from the code, so that they cannot be out of date."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import re
import textwrap
from pathlib import Path
from typing import Any

from eyehand.errors.field_docs import HEADING

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = (
    "perception",
    "perception.segmentation",
    "perception.superquadric",
    "perception.cameras",
    "perception.io",
    "grasping",
    "control",
    "control.tasks",
    "tactile",
    "tactile.sensors",
    "data_synth",
    "data_synth.scenes",
    "data_synth.render",
    "data_synth.cell",
    "data_synth.pad",
    "errors",
)
"""Packages with public names, in the order of the navigation."""
MOVED = {
    "../../examples/remote_robot.py": "../examples.md",
    "../../CONTRIBUTING.md": "../contributing.md",
    "docs/guides/": "guides/",
}
"""Link in a page of the repository → link in the site."""


def on_files(files: Any, config: Any) -> Any:
    """Add the generated pages."""
    from mkdocs.structure.files import File

    for name, text in pages().items():
        files.append(File.generated(config, name, content=text))
    return files


def on_page_markdown(markdown: str, **_more: Any) -> str:
    """Lead links out of the folder of the site to the generated pages."""
    for link, inside in MOVED.items():
        markdown = markdown.replace(f"]({link}", f"]({inside}")
    return markdown


def on_post_build(config: Any) -> None:
    """Write the index of the search as a script, which pages opened from the disk can load."""
    index = Path(config["site_dir"]) / "search" / "search_index.json"
    script = f"var __index = {index.read_text(encoding='utf-8')}"
    index.with_suffix(".js").write_text(script, encoding="utf-8")


def pages() -> dict[str, str]:
    """Return the generated pages: file name → Markdown."""
    return {
        "commands.md": commands_page(),
        "python.md": python_page(),
        **{f"python/{package}.md": package_page(package) for package in PACKAGES},
        "files.md": files_page(),
        "examples.md": examples_page(),
        "contributing.md": (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"),
    }


def commands_page() -> str:
    """Describe all commands with their options, from their functions."""
    from eyehand.apps.command_table import COMMANDS

    parts = ["# Commands", "`eyehand COMMAND --help` prints the same."]
    for command, (where, _) in COMMANDS.items():
        module, name = where.split(":")
        function = getattr(importlib.import_module(module), name)
        text, *_ = _docstring(function).partition("\n\nParameters\n")
        parts += [f"## eyehand {command}", _escaped(text)]
        parts.append(_options_table(function))
    return "\n\n".join(parts) + "\n"


def _options_table(function: Any) -> str:
    """Return a table of the options of a command: names, meaning and default."""
    from cyclopts import App

    app = App(help_format="plaintext")
    app.default(function)
    lines = ["| option | meaning | default |", "| --- | --- | --- |"]
    for option in app.assemble_argument_collection(parse_docstring=True):
        if not option.show:
            continue
        default = option.field_info.default
        # Of a switch that is on, the name that turns it off counts.
        names = [name for name in option.names if default is True or name not in option.negatives]
        meaning = _escaped(" ".join((option.parameter.help or "").split()))
        choices = option.get_choices() or ()
        if any(choice not in meaning for choice in choices):
            meaning += f" One of {', '.join(f'`{choice}`' for choice in choices)}."
        if isinstance(default, bool):
            shown = "on" if default else "off"
        else:
            shown = "" if default in (None, "", inspect.Parameter.empty) else f"`{default}`"
        lines.append(f"| {', '.join(f'`{name}`' for name in names)} | {meaning} | {shown} |")
    return "\n".join(lines)


def _escaped(text: str) -> str:
    """Return plain text that Markdown shows as it is, in a table too. Text in backticks stays."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([\\*_<>|\[\]])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def files_page() -> str:
    """Describe the members of all JSON files, from their schema."""
    schema = json.loads((ROOT / "docs" / "files.schema.json").read_text(encoding="utf-8"))
    parts = [
        "# JSON files",
        "All numbers are finite. Every object has all its members, except those marked as "
        "optional. A new member keeps the number of `schema`. A removed or changed one increases "
        "it. [files.schema.json](files.schema.json) is the JSON schema. The file of a hand has "
        "[a page of its own](guides/hand_description.md).",
    ]
    for name, form in schema["$defs"].items():
        parts += [f"## {name}", form["description"]]
        if "properties" in form:
            parts.append(
                "\n".join(("| member | type | meaning |", "| --- | --- | --- |", *_rows(form)))
            )
    return "\n\n".join(parts) + "\n"


def _rows(form: dict[str, Any], prefix: str = "") -> list[str]:
    """Return the rows of a table of members. Those of an object inside follow it."""
    rows = []
    for name, value in form["properties"].items():
        meaning = value["description"] + ("" if name in form["required"] else " Optional.")
        rows.append(f"| `{prefix}{name}` | {_json_type(value)} | {_escaped(meaning)} |")
        inner, inside = value.get("items", value), "[]." if "items" in value else "."
        if "properties" in inner:
            rows += _rows(inner, f"{prefix}{name}{inside}")
    return rows


def _json_type(value: dict[str, Any]) -> str:
    """Return the type of a member in words."""
    if "anyOf" in value:
        return " or ".join(_json_type(one) for one in value["anyOf"])
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        return f"[{name}](#{name})"
    if "const" in value or "enum" in value:
        return ", ".join(f"`{json.dumps(one)}`" for one in value.get("enum", [value.get("const")]))
    kinds = value["type"] if isinstance(value["type"], list) else [value["type"]]
    if "items" in value:
        count = f"{value['maxItems']} " if "maxItems" in value else ""
        kinds = [f"array of {count}{_json_type(value['items'])}", *kinds[1:]]
    return " or ".join(kinds)


def python_page() -> str:
    """List the packages with public names. Each has a page of its own."""
    parts = [
        "# Python",
        "Names in `__all__` are public. Others may change at any time.",
    ]
    for package in PACKAGES:
        module = importlib.import_module(f"eyehand.{package}")
        about = _docstring(module).partition("\n\n")[0]
        names = ", ".join(
            f"[`{name}`](python/{package}.md#{name.lower()})" for name in _documentable(module)
        )
        parts += [f"## [eyehand.{package}](python/{package}.md)", about, names]
    return "\n\n".join(parts) + "\n"


def package_page(package: str) -> str:
    """Describe the public names of a package, from their docstrings."""
    module = importlib.import_module(f"eyehand.{package}")
    parts = [f"# eyehand.{package}", _docstring(module).partition("\n\n")[0]]
    for name in _documentable(module):
        value = getattr(module, name)
        parts += [f"## {name}", _fenced(_signature(name, value)), _fenced(_docstring(value))]
        members = _members(value) if inspect.isclass(value) else {}
        if members:
            rows = (f"| `{name}` | {_escaped(text)} |" for name, text in members.items())
            parts.append("\n".join(("| member | meaning |", "| --- | --- |", *rows)))
    return "\n\n".join(parts) + "\n"


def _documentable(module: Any) -> list[str]:
    """Return the public classes and functions of a package."""
    values = ((name, getattr(module, name)) for name in module.__all__)
    return [name for name, value in values if inspect.isclass(value) or inspect.isroutine(value)]


def _members(value: type) -> dict[str, str]:
    """Return the documented public members of a class and its bases in eyehand.

    Fields are documented by the string below them, methods by their first paragraph.
    """
    members: dict[str, str] = {}
    for base in reversed(value.__mro__):
        if base.__module__.startswith("eyehand."):
            tree = ast.parse(textwrap.dedent(inspect.getsource(base))).body[0]
            assert isinstance(tree, ast.ClassDef)
            members |= _documented(tree.body)
    return {name: text for name, text in members.items() if not name.startswith("_")}


def _documented(body: list[ast.stmt]) -> dict[str, str]:
    """Return name → first paragraph of the fields and methods of a class or of `__init__`."""
    found: dict[str, str] = {}
    for statement, after in zip(body, [*body[1:], ast.Pass()], strict=True):
        name, text = "", None
        if isinstance(statement, ast.FunctionDef):
            text = ast.get_docstring(statement)
            name = statement.name + ("" if _is_property(statement) else "()")
            if statement.name == "__init__":
                found |= _documented(statement.body)
        elif isinstance(statement, ast.AnnAssign | ast.Assign):
            targets = (
                [statement.target] if isinstance(statement, ast.AnnAssign) else statement.targets
            )
            name = ast.unparse(targets[0]).removeprefix("self.")
            if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                text = inspect.cleandoc(str(after.value.value))
        if text:
            found[name] = " ".join(text.partition("\n\n")[0].split())
    return found


def _is_property(function: ast.FunctionDef) -> bool:
    return any(ast.unparse(one).endswith("property") for one in function.decorator_list)


def examples_page() -> str:
    """Show the scripts of `examples/`."""
    parts = ["# Examples", "Each script runs in the tests."]
    for path in sorted((ROOT / "examples").glob("*.py")):
        code = path.read_text(encoding="utf-8").rstrip()
        parts += [f"## {path.stem.replace('_', ' ').capitalize()}", f"```python\n{code}\n```"]
    return "\n\n".join(parts) + "\n"


def _docstring(value: Any) -> str:
    # The fields stand in the table of members.
    return (inspect.getdoc(value) or "").partition(f"\n\n{HEADING}\n")[0]


def _signature(name: str, value: Any) -> str:
    try:
        # Annotations are strings: their quotes are left out.
        return re.sub(r"(: |-> )'([^']*)'", r"\1\2", f"{name}{inspect.signature(value)}")
    except (TypeError, ValueError):
        return name


def _fenced(text: str) -> str:
    return f"```text\n{text}\n```"
