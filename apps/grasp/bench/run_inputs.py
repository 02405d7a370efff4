"""What an evaluation of grasping is asked for, checked before anything runs, and what it is named.

What is wrong with a robot's file or with a folder's sizes would otherwise be found once in every
scene, and counted there as a failed pick.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from eyehand.errors import InputError

from ...bench.machine import core_count
from .cluster import check_address
from .conditions import folder_digest, source_digest
from .robot_digest import robot_digest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .jobs import Condition, Family

MOST_OBJECTS = 15
"""More do not fit on the table."""
MOST_SEED = 2**63 - 1
"""Rows keep seeds in 64 bits."""
NAME_LETTERS = 8
"""Of the digest in the name of a run's own folder."""


@dataclass(frozen=True)
class Machines:
    """Where scenes are run."""

    jobs: int
    """Processes here."""
    cluster: str = ""
    """Address of a scheduler that takes them instead."""

    @property
    def told(self) -> str:
        """How many times were taken at once, in words: those who read them must know."""
        if self.cluster:
            return "times are those of the cluster's workers, whatever else these did"
        if self.jobs == 1:
            return "times are those of one process, with no other scene beside it"
        return (
            f"times were taken with {self.jobs} processes side by side: perceive and plan are "
            "longer than in one alone (--jobs 1)"
        )


def check_scenes(scenes: int, seed: int, count: int) -> None:
    """Check number and first seed of the scenes, and the objects of each.

    Raises
    ------
    InputError
        If one is out of its range.
    """
    if scenes < 1:
        raise InputError(f"--scenes must be >= 1, got {scenes}")
    if seed < 0:
        raise InputError(f"--seed must be >= 0, got {seed}")
    if seed + scenes - 1 > MOST_SEED:
        raise InputError(f"the last seed must be below 2**63, got --seed {seed}")
    if not 1 <= count <= MOST_OBJECTS:
        raise InputError(f"--count must be from 1 to {MOST_OBJECTS}, got {count}")


def chosen_machines(jobs: int | None, cluster: str) -> Machines:
    """Check where scenes shall run."""
    if jobs is not None and jobs < 1:
        raise InputError(f"--jobs must be >= 1, got {jobs}")
    if jobs is not None and cluster:
        raise InputError("--jobs is for processes here: leave it out with --cluster")
    if cluster:
        check_address(cluster)
    return Machines(jobs or core_count(), cluster)


def checked_dials(perception: str, control: str) -> tuple[str, str]:
    """Check the names of dials."""
    from .dials import CONTROL, PERCEPTION, check_dials

    check_dials("perception", PERCEPTION, [perception])
    check_dials("control", CONTROL, [control])
    return perception, control


def trial_extras(
    purpose: str, objects: Path | None, robot: Path | None, hand_frame: str
) -> dict[str, Any]:
    """Check what comes from files, and name it as trials do: on any machine, with its whole path.

    Raises
    ------
    InputError
        If a file is missing, a mesh does not do, one of --robot and --hand-frame is missing, or no
        robot can be built of them.
    """
    if objects is not None:
        from eyehand.data_synth.scenes import read_objects

        read_objects(objects)
    if robot is not None and not robot.is_file():
        raise InputError(f"--robot {robot}: there is no such file, expected an MJCF")
    if (robot is None) != (not hand_frame):
        raise InputError("--robot and --hand-frame go together: a robot, and the site in its palm")
    if robot is not None:
        from .trial import GraspTrial, cell_of

        cell_of((), GraspTrial(robot=str(robot), hand_frame=hand_frame))
    return {
        "purpose": purpose,
        "objects_dir": str(objects.resolve()) if objects else "",
        "robot": str(robot.resolve()) if robot else "",
        "hand_frame": hand_frame,
    }


def check_room(
    objects: Path | None, conditions: Sequence[Condition], seeds: Sequence[int], count: int
) -> None:
    """Check that a folder's objects have room in all scenes.

    Raises
    ------
    InputError
        If in one they have not.
    """
    if objects is None:
        return
    from ..mesh_scenes import check_folder_scenes

    families: dict[Family, None] = dict.fromkeys(condition.family for condition in conditions)
    check_folder_scenes(objects, [(one, seed) for one in families for seed in seeds], count)


def run_options(
    conditions: Sequence[Condition], seed: int, count: int, more: Mapping[str, Any]
) -> dict[str, Any]:
    """All that a folder's rows depend on, but for the number of scenes: more of them may follow."""
    objects, robot = more["objects_dir"], more["robot"]
    files = {"objects_dir_digest": folder_digest(Path(objects))} if objects else {}
    files |= {"robot_digest": robot_digest(Path(robot))} if robot else {}
    return {
        "rows": [condition.name for condition in conditions],
        "seed": seed,
        "count": count,
        **more,
        **files,
        "code": source_digest(),
    }


def own_folder(parent: Path, conditions: Sequence[Condition], options: Mapping[str, Any]) -> Path:
    """Name the folder of a run that was given none: other options never meet in it.

    The same command finds it again, with more scenes too.
    """
    families = "-".join(dict.fromkeys(condition.family for condition in conditions))
    text = json.dumps(dict(options), sort_keys=True)
    digest = hashlib.sha256(text.encode()).hexdigest()[:NAME_LETTERS]
    return parent / f"{families}_{digest}"
