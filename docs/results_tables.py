"""Tables of results, written from the JSON that the measuring commands print.

Store a measurement, then rewrite the tables of all pages:

    eyehand evaluate grasp --scenes 40 --json > report.json
    python docs/results_tables.py store NAME "eyehand evaluate grasp --scenes 40" report.json
    python docs/results_tables.py

The file may also come from `make bench ARGS="--benchmark-json=report.json"`. Several
reports `LABEL=report.json` make one table; their rows get the field `label`.

A page names the columns of a table before it. Each is a heading and a format of the row's fields:

    <!-- results NAME: scenes={name} | successful picks={success_pct:.1f} % -->
    <!-- end of results -->

`results NAME=LABEL + NAME=LABEL:` joins the rows of several stored reports. Their rows get the
field `label`, and each report keeps its own command, date and machine below the table.
`results NAME where FIELD=VALUE or VALUE:` keeps the rows with these values. Values that are
unknown, or that only other rows have, are shown as -.
"""

from __future__ import annotations

import datetime
import json
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
BLOCK = re.compile(
    r"(<!-- results ([^:]+?)(?: where (\w+)=(.*?))?: (.*?) -->\n).*?(<!-- end of results -->)",
    re.DOTALL,
)
UNKNOWN = "-"
OMITTED = ("out", "points")
"""Fields of a report that hold paths of the machine, or that no table uses."""


def main(arguments: list[str]) -> int:
    """Store a report, or rewrite all tables; return the exit code."""
    if arguments[:1] == ["store"] and len(arguments) >= 4:
        name, command, *files = arguments[1:]
        store(name, command, joined_report(files))
    elif arguments:
        sys.stderr.write(f"usage: {__doc__}")
        return 2
    for page in sorted(DOCS.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        if text != (new := with_tables(text)):
            page.write_text(new, encoding="utf-8")
    return 0


def joined_report(files: Sequence[str]) -> dict[str, Any]:
    """Return the report of a file, or the first of several with the rows of all.

    Each file is a path, or ``LABEL=PATH``. A label becomes the field ``label`` of its rows.
    """
    report: dict[str, Any] = {}
    rows: list[dict[str, Any]] = []
    for file in files:
        label, _, path = file.rpartition("=")
        content = json.loads(Path(path).read_text(encoding="utf-8"))
        if "benchmarks" in content:
            content = {"rows": [_timed(mark) for mark in content["benchmarks"]]}
        report = report or content
        rows += [({"label": label} if label else {}) | row for row in content["rows"]]
    return report | {"rows": rows}


def _timed(mark: dict[str, Any]) -> dict[str, Any]:
    """Return the row of one benchmark of pytest-benchmark: what was timed, median and quartiles."""
    name = mark["name"].removeprefix("test_").removeprefix("benchmark_").replace("_", " ")
    times = {key: 1000.0 * mark["stats"][key] for key in ("median", "q1", "q3")}
    return {"name": name} | {f"{key}_ms": time for key, time in times.items()}


def store(name: str, command: str, report: dict[str, Any], folder: Path = DOCS / "results") -> Path:
    """Write a report with its command, today's date and this machine to a folder of results."""
    from eyehand.apps.bench.machine import machine_line

    kept = {"machine": machine_line()}
    kept |= {key: value for key, value in report.items() if key not in OMITTED}
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    folder.mkdir(exist_ok=True)
    file = folder / f"{name}.json"
    content = {"command": command, "date": today, "report": kept}
    file.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return file


def with_tables(text: str, folder: Path = DOCS / "results") -> str:
    """Return a page with its tables written anew."""

    def block(match: re.Match[str]) -> str:
        contents = {
            label: json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
            for name, label in reports_of(match[2])
        }
        where = {match[3]: match[4]} if match[3] else {}
        return f"{match[1]}\n{table(contents, match[5], where)}\n\n{match[6]}"

    return BLOCK.sub(block, text)


def reports_of(names: str) -> list[tuple[str, str]]:
    """Return the stored reports of a marker, each with the label of its rows or an empty one."""
    pairs = [part.strip().partition("=") for part in names.split(" + ")]
    return [(name, label) for name, _, label in pairs]


def table(contents: Mapping[str, dict[str, Any]], columns: str, where: Mapping[str, str]) -> str:
    """Return a table and the lines that say how it was measured.

    Parameters
    ----------
    contents
        Files of `store`, by the label of their rows.
    columns
        ``heading={field:format} | …``; the fields are those of the report's rows.
    where
        Fields and values of the rows to keep.

    Raises
    ------
    ValueError
        If no row has these values.
    """
    pairs = [column.strip().split("=", 1) for column in columns.split("|")]
    lines = [[heading for heading, _ in pairs], ["---"] * len(pairs)]
    stored = [
        ({"label": label} if label else {}) | row
        for label, content in contents.items()
        for row in content["report"]["rows"]
    ]
    fields = dict.fromkeys(field for row in stored for field in row)
    rows = [fields | row for row in stored]
    kept = [
        row
        for row in rows
        if all(row.get(key) in values.split(" or ") for key, values in where.items())
    ]
    if not kept:
        commands = [content["command"] for content in contents.values()]
        raise ValueError(f"no row of {commands} has {dict(where)}")
    lines += [[_filled(form, row) for _, form in pairs] for row in kept]
    text = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    origins = [_origin(content, label) for label, content in contents.items()]
    return f"{text}\n\n" + "\n".join(origins)


def _origin(content: Mapping[str, Any], label: str) -> str:
    report = content["report"]
    hidden = report.get("seed") is None or "--seed" in content["command"]
    seed = "" if hidden else f", seed {report['seed']}"
    machine = report.get("machine", "machine not recorded")
    line = f"`{content['command']}`{seed}, {content['date']}, {machine}."
    return f"- {label}: {line}" if label else line


def _filled(form: str, row: Mapping[str, Any]) -> str:
    unknown = [key for key, value in row.items() if value is None]
    plain = re.sub(rf"{{({'|'.join(unknown)})(:[^}}]*)?}}", UNKNOWN, form) if unknown else form
    return plain.format(**row)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
