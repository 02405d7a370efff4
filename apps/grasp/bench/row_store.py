"""Store the rows of an evaluation, one JSON file per finished scene.

Each file is written atomically under the unique key of its scene. A killed run loses only the
scenes in progress, and a scene that runs twice counts once.
"""

from __future__ import annotations

import json
from dataclasses import fields
from math import isfinite
from typing import TYPE_CHECKING, Any

from eyehand.apps.console import counted, say
from eyehand.errors import InputError

from ...output_files import make_folder, write_text
from ...run_folder import claim_folder
from .pick_row import PickRow

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from .jobs import SceneJob, SceneOutcome

ROWS_FOLDER, OPTIONS_FILE = "rows", "options.json"
SCENE, PICK = "scene", "pick"
"""Values of `record` in a row."""
FAULT = "fault"
"""Outcome of a scene that raised an exception, and of the one failed pick counted for it."""

_UNKNOWN = dict.fromkeys(
    [field.name for field in fields(PickRow)]
    + ["tried", "placed", "total", "left", "stopped", "cpu_seconds", "work_seconds"]
)
"""Values of a pick or scene that a row need not have: after a fault, or of an object without a
pick."""


class RowStore:
    """The rows in a folder, opened by :func:`open_rows`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / ROWS_FOLDER

    def finished(self) -> set[str]:
        """Return the keys of the finished scenes."""
        return {path.stem for path in self._parts()}

    def add(self, job: SceneJob, outcome: SceneOutcome) -> None:
        """Store the row of a scene and the rows of its picks."""
        rows = scene_records(job, outcome)
        write_text(self.folder / f"{job.key}.json", json.dumps(rows) + "\n")

    def read(self, jobs: Iterable[SceneJob]) -> list[dict[str, Any]]:
        """Return the rows of the finished scenes, in the order of the jobs."""
        rows: list[dict[str, Any]] = []
        for job in jobs:
            path = self.folder / f"{job.key}.json"
            if not path.is_file():
                continue
            try:
                rows += json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError) as error:
                raise InputError(
                    f"cannot read rows from {path}: remove it and run again"
                ) from error
        return rows

    def clear(self) -> None:
        """Remove all rows."""
        for path in self._parts():
            path.unlink()

    def _parts(self) -> list[Path]:
        return [path for path in self.folder.glob("*.json") if not path.name.startswith(".")]


def open_rows(folder: Path, options: Mapping[str, Any], *, fresh: bool = False) -> RowStore:
    """Open the rows of a new or a continued run.

    Parameters
    ----------
    folder
        Output folder of the run, created if needed.
    options
        Everything that the rows depend on, as JSON values. It is stored beside the rows.
    fresh
        Discard the rows of earlier runs.

    Raises
    ------
    InputError
        If the folder holds rows of other options. The message names the differences.
    """
    store = RowStore(folder)
    claim_folder(folder)
    make_folder(store.folder)
    for path in store.folder.glob(".*.json"):
        # Temporary file of a killed run: no other process has the folder.
        path.unlink(missing_ok=True)
    if fresh:
        store.clear()
    wanted = json.loads(json.dumps(dict(options)))
    file = folder / OPTIONS_FILE
    if store.finished():
        differing = _differences(_stored_options(file), wanted)
        if differing:
            raise InputError(
                f"{folder} holds rows of other options ({differing}): use those options, "
                "another folder with --out, or --fresh to discard the rows"
            )
        say(
            f"continuing after {counted(len(store.finished()), 'finished scene')} in {store.folder}"
        )
    write_text(file, json.dumps(wanted, indent=1) + "\n")
    return store


def scene_records(job: SceneJob, outcome: SceneOutcome) -> list[dict[str, Any]]:
    """Return the row of a scene and the rows of its picks.

    An object without a pick counts as a failed pick (`tried` is false), and so does a fault.
    """
    head = {"key": job.key, "row": job.row, **job.trial}
    if outcome.fault:
        total = int(job.trial["objects"])
        cause = {"outcome": FAULT, "reason": outcome.fault}
        scene = {"placed": 0, "total": total, "left": total, "stopped": FAULT}
        return [
            _record(SCENE, {**head, **cause, **scene}),
            _record(PICK, {**head, **cause, "pick": 0, "tried": False, "success": False}),
        ]
    result = dict(outcome.result)
    picks = [{"tried": True, **pick} for pick in result.pop("picks", [])]
    unattempted = [{"tried": False, "success": False, **item} for item in result.pop("untried", [])]
    scene = {"outcome": "done", "reason": "", **result}
    return [
        _record(SCENE, {**head, **scene}),
        *(
            _record(PICK, {**head, "pick": number, **pick})
            for number, pick in enumerate([*picks, *unattempted])
        ),
    ]


def _record(kind: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row. A number that is not finite becomes None."""
    known = {
        name: None if isinstance(value, float) and not isfinite(value) else value
        for name, value in values.items()
    }
    return {"record": kind, **_UNKNOWN, **known}


def _stored_options(file: Path) -> dict[str, Any]:
    try:
        stored = json.loads(file.read_text(encoding="utf-8"))
        return stored if isinstance(stored, dict) else {}
    except (OSError, ValueError):
        return {}


def _differences(stored: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    names = [name for name in {**stored, **wanted} if stored.get(name) != wanted.get(name)]
    return ", ".join(f"{name}: was {stored.get(name)}, is {wanted.get(name)}" for name in names)
