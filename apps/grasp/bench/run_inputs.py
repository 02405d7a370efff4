"""Validate the inputs of an evaluation before any scene runs, and name its output folder.

Without this check, a wrong robot file or mesh folder would count as a failed pick in every scene.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from eyehand.data_synth.scenes import Split
from eyehand.errors import InputError

from ...bench.machine import core_count
from ..robot_choice import RobotChoice
from .cluster import check_address
from .conditions import folder_digest, robot_digest, source_digest
from .jobs import Condition, Family

MAX_OBJECTS = 15
"""Maximum number of objects on the table."""
MAX_SEED = 2**63 - 1
"""Rows store seeds as 64-bit integers."""
DIGEST_LENGTH = 8
"""Length of the digest in the name of a default output folder."""
JOBS_PER_CORE = 4
"""Maximum processes per core. More only take memory."""
MAX_DENSITY = 2e4
"""Maximum of --density, kg/m³: that of gold. More is a typing error."""
QUICK_SCENES, QUICK_OBJECTS = 2, 2
"""Maximum scenes and objects of a quick run."""


@dataclass(frozen=True)
class Machines:
    """The machines that run the scenes."""

    jobs: int
    """Number of local processes."""
    cluster: str = ""
    """Address of a Dask scheduler that runs them instead."""

    @property
    def timing_note(self) -> str:
        """The conditions under which times were measured, for the reader."""
        if self.cluster:
            return "times were measured on the cluster's workers under unknown load"
        if self.jobs == 1:
            return "times were measured in one process"
        return (
            f"times were measured with {self.jobs} parallel processes: perceive and plan take "
            "longer than in one process (--jobs 1)"
        )


def checked_scenes(scenes: int, seed: int, count: int, *, quick: bool) -> tuple[range, int]:
    """Return the seeds of the scenes and the number of objects, reduced for a quick run.

    Raises
    ------
    InputError
        If a value is out of range.
    """
    if scenes < 1:
        raise InputError(f"--scenes must be >= 1, got {scenes}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if seed + scenes - 1 > MAX_SEED:
        raise InputError(f"the last seed must be below 2**63, got --seed {seed}")
    check_count(count)
    if quick:
        scenes, count = min(scenes, QUICK_SCENES), min(count, QUICK_OBJECTS)
    return range(seed, seed + scenes), count


def check_count(count: int) -> None:
    """Check the number of objects.

    Raises
    ------
    InputError
        If it is out of range.
    """
    if not 1 <= count <= MAX_OBJECTS:
        raise InputError(f"--count must be from 1 to {MAX_OBJECTS}, got {count}")


def checked_machines(jobs: int | None, cluster: str) -> Machines:
    """Check --jobs and --cluster."""
    most = JOBS_PER_CORE * core_count()
    if jobs is not None and not 1 <= jobs <= most:
        raise InputError(f"--jobs must be from 1 to {most} on {core_count()} cores, got {jobs}")
    if jobs is not None and cluster:
        raise InputError("--jobs is for local processes: leave it out with --cluster")
    if cluster:
        check_address(cluster)
    return Machines(jobs or core_count(), cluster)


def checked_dials(perception: str, control: str) -> tuple[str, str]:
    """Check the names of the dials."""
    from .dials import CONTROL, PERCEPTION, check_dial

    check_dial("perception", PERCEPTION, perception)
    check_dial("control", CONTROL, control)
    return perception, control


def trial_extras(
    purpose: str, objects: Path | None, robot: RobotChoice | None = None
) -> dict[str, Any]:
    """Check the files of a trial and return its fields for them, with absolute paths.

    Raises
    ------
    InputError
        If a file is missing, a mesh is invalid, or the robot cannot be built.
    """
    if objects is not None:
        from eyehand.data_synth.scenes import read_objects

        read_objects(objects)
    return {
        "purpose": purpose,
        "objects_dir": str(objects.resolve()) if objects else "",
        **(robot or RobotChoice()).trial_fields(),
    }


def with_objects(
    conditions: Sequence[Condition], objects: Path | None, split: Split, density: float | None
) -> list[Condition]:
    """Return the conditions with the half and the density of the objects of a folder.

    Raises
    ------
    InputError
        If the density is not positive, or one of them is given without a folder.
    """
    if objects is None and (split != "all" or density is not None):
        raise InputError("--split and --density need --objects FOLDER")
    if density is not None and not 0.0 < density < MAX_DENSITY:
        raise InputError(f"--density must lie in (0, {MAX_DENSITY:g}) kg/m³, got {density}")
    return [replace(one, split=split, density=density or 0.0) for one in conditions]


def check_objects_fit(
    objects: Path | None, conditions: Sequence[Condition], seeds: Sequence[int], count: int
) -> None:
    """Check that the objects of a folder fit on the table in all scenes.

    Raises
    ------
    InputError
        If they do not fit in a scene.
    """
    if objects is None:
        return
    from ..mesh_scenes import ObjectSource, check_mesh_scenes

    families: dict[Family, None] = dict.fromkeys(condition.family for condition in conditions)
    source = ObjectSource(str(objects), conditions[0].split, conditions[0].density or None)
    check_mesh_scenes(source, [(family, seed) for family in families for seed in seeds], count)


def run_options(
    conditions: Sequence[Condition], seed: int, count: int, extras: Mapping[str, Any]
) -> dict[str, Any]:
    """Return everything that stored rows depend on. The number of scenes may grow later."""
    objects = extras["objects_dir"]
    files = {"objects_dir_digest": folder_digest(Path(objects))} if objects else {}
    for name in ("robot", "arm", "hand"):
        if Path(extras.get(name, "")).is_file():
            files[f"{name}_digest"] = robot_digest(Path(extras[name]))
    return {
        "rows": [condition.name for condition in conditions],
        "seed": seed,
        "count": count,
        **extras,
        **files,
        "code": source_digest(),
    }


def default_folder(
    parent: Path, conditions: Sequence[Condition], options: Mapping[str, Any]
) -> Path:
    """Return an output folder with a name that identifies the options.

    The same command finds it again, also with more scenes.
    """
    families = "-".join(dict.fromkeys(condition.family for condition in conditions))
    text = json.dumps(dict(options), sort_keys=True)
    digest = hashlib.sha256(text.encode()).hexdigest()[:DIGEST_LENGTH]
    return parent / f"{families}_{digest}"
