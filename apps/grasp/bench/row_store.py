"""Store the rows of an evaluation, one Parquet file per finished scene.

Each file is written atomically under the unique key of its scene. A killed run loses only the
scenes in progress, and a scene that runs twice counts once.
"""

from __future__ import annotations

import json
from math import isfinite
from typing import TYPE_CHECKING, Any

from eyehand.apps.console import counted, say
from eyehand.errors import InputError
from eyehand.perception.io import atomic_write

from ...output_files import make_folder, write_text
from ...run_folder import claim_folder

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from .jobs import SceneJob, SceneOutcome

ROWS_FOLDER, OPTIONS_FILE = "rows", "options.json"
SCENE, PICK = "scene", "pick"
"""Values of the column `record`."""
FAULT = "fault"
"""Outcome of a scene that raised an exception, and of the one failed pick counted for it."""

_TEXT, _COUNT, _NUMBER, _FLAG = "string", "int64", "float64", "bool"
TRIAL_COLUMNS = {
    "family": _TEXT,
    "seed": _COUNT,
    "objects": _COUNT,
    "friction": _NUMBER,
    "shake": _NUMBER,
    "load_step": _NUMBER,
    "known": _FLAG,
    "purpose": _TEXT,
    "perception": _TEXT,
    "control": _TEXT,
    "objects_dir": _TEXT,
    "split": _TEXT,
    "density": _NUMBER,
    "robot": _TEXT,
    "hand_frame": _TEXT,
    "arm": _TEXT,
    "hand": _TEXT,
    "mount": _TEXT,
}
"""Columns of the trial, in every row."""
PICK_COLUMNS = {
    "pick": _COUNT,
    "tried": _FLAG,
    "object": _TEXT,
    "kind": _TEXT,
    "prototype": _TEXT,
    "approach": _TEXT,
    "rows": _COUNT,
    "success": _FLAG,
    "perceive_ms": _NUMBER,
    "plan_ms": _NUMBER,
    "seconds": _NUMBER,
    "wall_seconds": _NUMBER,
    "touched_before": _COUNT,
    "pads": _COUNT,
    "curl": _NUMBER,
    "pushed": _FLAG,
    "touched_pushing": _COUNT,
    "displacement": _NUMBER,
    "score": _NUMBER,
    "hold": _NUMBER,
    "lifted": _FLAG,
    "kept": _FLAG,
    "squeeze": _NUMBER,
}
"""Columns of a pick's row."""
SCENE_COLUMNS = {
    "placed": _COUNT,
    "total": _COUNT,
    "left": _COUNT,
    "stopped": _TEXT,
    "cpu_seconds": _NUMBER,
    "work_seconds": _NUMBER,
}
"""Columns of a scene's row."""
COLUMNS = {
    "record": _TEXT,
    "key": _TEXT,
    "row": _TEXT,
    "outcome": _TEXT,
    "reason": _TEXT,
    **TRIAL_COLUMNS,
    **PICK_COLUMNS,
    **SCENE_COLUMNS,
    "more": _TEXT,
}
"""All columns and their types. `more` holds further fields of a result as JSON."""


class RowStore:
    """The rows in a folder, opened by :func:`open_rows`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / ROWS_FOLDER

    def finished(self) -> set[str]:
        """Return the keys of the finished scenes."""
        return {path.stem for path in self._parts()}

    def add(self, job: SceneJob, outcome: SceneOutcome) -> None:
        """Store the row of a scene and the rows of its picks."""
        import pyarrow
        from pyarrow import parquet

        schema = pyarrow.schema([(name, _arrow(kind)) for name, kind in COLUMNS.items()])
        table = pyarrow.Table.from_pylist(scene_records(job, outcome), schema=schema)
        with atomic_write(self.folder / f"{job.key}.parquet") as temporary:
            parquet.write_table(table, temporary, compression="zstd")

    def read(self, jobs: Iterable[SceneJob]) -> list[dict[str, Any]]:
        """Return the rows of the finished scenes, in the order of the jobs."""
        import pyarrow
        from pyarrow import parquet

        rows = []
        for job in jobs:
            path = self.folder / f"{job.key}.parquet"
            if not path.is_file():
                continue
            try:
                rows += parquet.ParquetFile(path).read().to_pylist()
            except (OSError, pyarrow.ArrowException) as error:
                raise InputError(
                    f"cannot read rows from {path}: remove it and run again"
                ) from error
        return rows

    def clear(self) -> None:
        """Remove all rows."""
        for path in self._parts():
            path.unlink()

    def _parts(self) -> list[Path]:
        return [path for path in self.folder.glob("*.parquet") if not path.name.startswith(".")]


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
    for path in store.folder.glob(".*.parquet"):
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
    trial = {name: job.trial.get(name) for name in TRIAL_COLUMNS}
    head = {"key": job.key, "row": job.row, **trial}
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
    known = {name: _as_type(values.get(name), column) for name, column in COLUMNS.items()}
    more = {name: value for name, value in values.items() if name not in COLUMNS}
    return {**known, "record": kind, "more": json.dumps(more) if more else None}


def _as_type(value: Any, kind: str) -> Any:
    """Convert a value to the type of its column. A non-finite number becomes None."""
    if value is None:
        return None
    if kind == _NUMBER:
        return float(value) if isfinite(float(value)) else None
    if kind == _COUNT:
        return len(value) if isinstance(value, list) else int(value)
    return bool(value) if kind == _FLAG else str(value)


def _arrow(kind: str) -> Any:
    import pyarrow

    return pyarrow.bool_() if kind == _FLAG else getattr(pyarrow, kind)()


def _stored_options(file: Path) -> dict[str, Any]:
    try:
        stored = json.loads(file.read_text(encoding="utf-8"))
        return stored if isinstance(stored, dict) else {}
    except (OSError, ValueError):
        return {}


def _differences(stored: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    names = [name for name in {**stored, **wanted} if stored.get(name) != wanted.get(name)]
    return ", ".join(f"{name}: was {stored.get(name)}, is {wanted.get(name)}" for name in names)
