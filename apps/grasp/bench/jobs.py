"""What a grasping evaluation runs: conditions, a scene for each of their seeds, and its outcome.

Jobs and outcomes are plain text and numbers, because they travel: to other processes, to other
machines, and into files that a later run reads.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import traceback
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from eyehand.errors import DeviceError

if TYPE_CHECKING:
    from collections.abc import Iterable

Family = Literal["single", "packed", "pile"]
"""How the objects of a scene stand: one alone, upright side by side, dropped on each other."""
RunTrial = Callable[[dict[str, Any]], dict[str, Any]]
"""Runs the trial of these fields and gives the fields of its result. It is found by its name in
other processes, so it is a function of a module."""

TRIAL_MODULE = "eyehand.apps.grasp.bench.trial"
"""Where trials are run: with the physics engine and all kernels, imported only to run one."""
MACHINE_FAULTS = (MemoryError, OSError, ImportError, DeviceError)
"""What a trial raises for no reason of its own: a full disk, no graphics, another version."""
KEY_LETTERS = 12
"""Of the digest in a key: two of a million scenes share one with a chance of 1 in 500."""


@dataclass(frozen=True)
class Condition:
    """Under what a row of the table was measured."""

    family: Family
    """How the objects stand."""
    friction: float = 1.0
    """Coulomb coefficient of the hand's pads."""
    shake: float = 0.0
    """How long the hand shakes after each lift, s."""
    known: bool = False
    """Whether true solids take the place of what the camera saw."""
    perception: str = "default"
    """Name of a perception dial."""
    control: str = "default"
    """Name of a control dial."""

    @property
    def name(self) -> str:
        """Say it in words, for tables."""
        words = [f"{self.family}, known" if self.known else self.family]
        words += [f"friction {self.friction:g}"] if self.friction != 1.0 else []
        words += [f"shake {self.shake:g} s"] if self.shake else []
        words += [f"{self.perception} perception"] if self.perception != "default" else []
        words += [f"{self.control} control"] if self.control != "default" else []
        return ", ".join(words)


@dataclass(frozen=True)
class SceneJob:
    """One scene to clear."""

    row: str
    """Name of its condition."""
    trial: Mapping[str, Any]
    """Fields of its trial."""

    @property
    def key(self) -> str:
        """Name that no scene with another trial has, fit for a file."""
        text = json.dumps(dict(self.trial), sort_keys=True)
        digest = hashlib.sha256(text.encode()).hexdigest()[:KEY_LETTERS]
        return f"{self.trial['family']}_{self.trial['seed']:05d}_{digest}"


@dataclass(frozen=True)
class SceneOutcome:
    """What became of a scene: a result, a fault, or nothing that tells of grasping."""

    result: Mapping[str, Any] = field(default_factory=dict)
    """Fields of the trial's result; empty at a fault."""
    fault: str = ""
    """What the trial raised: it counts, as a scene not cleared."""
    lost: str = ""
    """Why the machine gave no outcome (killed, out of memory, far too late): it counts for nothing,
    and the scene is to be tried again."""


def scene_jobs(
    conditions: Iterable[Condition], seeds: Iterable[int], objects: int, more: Mapping[str, Any]
) -> list[SceneJob]:
    """List the scenes of all conditions, each with the same seeds, seed by seed.

    So the conditions share their scenes, and a run that is stopped early has seen as much of each.

    Parameters
    ----------
    conditions
        Rows of the table.
    seeds
        One scene each.
    objects
        Of a scene; a single one has 1.
    more
        Further fields of every trial.
    """
    rows = list(conditions)
    return [
        SceneJob(
            condition.name,
            {
                **asdict(condition),
                "seed": seed,
                "objects": 1 if condition.family == "single" else objects,
                **more,
            },
        )
        for seed in seeds
        for condition in rows
    ]


def attempt(run: RunTrial, trial: Mapping[str, Any]) -> SceneOutcome:
    """Run a trial; what it raises becomes a fault, with the place where it was raised.

    What the machine is to blame for is no fault of the trial: it has no outcome then.
    """
    try:
        result = run(dict(trial))
        # What does not fit into text would break on its way, where nobody could tell whose it was.
        return SceneOutcome(result=json.loads(json.dumps(result, default=_plain)))
    except MACHINE_FAULTS as error:
        return SceneOutcome(lost=_told(error))
    except Exception as error:
        return SceneOutcome(fault=_told(error))


def run_grasp_trial(trial: dict[str, Any]) -> dict[str, Any]:
    """Clear a scene with the simulated robot; fields of the result without those of the trial."""
    module = importlib.import_module(TRIAL_MODULE)
    _ready()
    result = module.run_trial(module.GraspTrial(**trial))
    own = {f.name: getattr(result, f.name) for f in fields(result) if f.name != "trial"}
    return {**own, "picks": [asdict(pick) for pick in result.picks]}


@cache
def _ready() -> None:
    """Load kernels before times are taken, once in a process."""
    from ..warm_up import ready_grasping

    ready_grasping()


def _told(error: Exception) -> str:
    said = " ".join(str(error).split())
    steps = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(steps[-1].filename).name}:{steps[-1].lineno})" if steps else ""
    return f"{type(error).__name__}: {said}{place}" if said else f"{type(error).__name__}{place}"


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    raise TypeError(f"a trial's result must be plain numbers and text, got {type(value).__name__}")
