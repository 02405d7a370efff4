"""The scenes of a grasping evaluation as jobs, and their outcomes.

Jobs and outcomes hold plain text and numbers, because they are sent to other processes and machines
and stored in files.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import traceback
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from eyehand.errors import DeviceError

from ...bench.peak_memory import return_freed_memory

if TYPE_CHECKING:
    from eyehand.data_synth.scenes import Split

Family = Literal["single", "packed", "pile"]
"""Arrangement of the objects: a single one, several upright ones, several dropped ones."""
RunTrial = Callable[[dict[str, Any]], dict[str, Any]]
"""Run the trial with these fields and return the fields of its result. Other processes import it by
name, so it must be a module-level function."""

TRIAL_MODULE = "eyehand.apps.grasp.bench.trial"
"""Module that runs trials. It is imported lazily because it loads physics and all kernels."""
MACHINE_FAULTS = (MemoryError, OSError, ImportError, DeviceError)
"""Exceptions of the machine, not of the trial: a full disk, no graphics, a different version."""
KEY_LENGTH = 12
"""Length of the digest in a key. A million scenes have a collision with probability 1/500."""


@dataclass(frozen=True)
class Condition:
    """The conditions of a row of the table."""

    family: Family
    """Arrangement of the objects."""
    friction: float = 1.0
    """Coulomb friction coefficient of the hand's pads."""
    shake: float = 0.0
    """Duration of the shake after each lift, s."""
    known: bool = False
    """Whether the true solids replace perception."""
    perception: str = "default"
    """Name of the perception dial."""
    control: str = "default"
    """Name of the control dial."""
    split: Split = "all"
    """Half of the objects of a folder that are drawn: all, development, held-out."""
    density: float = 0.0
    """Density of the objects of a folder, kg/m³; 0 for the masses of their files."""
    load_step: float = 1.0
    """Load on the lifted object while the hand checks it, as a multiple of its weight."""

    sensor: str = ""
    """Sensor model of the hand's pads; empty for exact touch."""

    @property
    def name(self) -> str:
        """Name for tables: the values that differ from the defaults."""
        words = [f"{self.family}, known" if self.known else self.family]
        words += [f"friction {self.friction:g}"] if self.friction != 1.0 else []
        words += [f"shake {self.shake:g} s"] if self.shake else []
        words += [f"load {self.load_step:g} weights"] if self.load_step != 1.0 else []
        words += [f"{self.perception} perception"] if self.perception != "default" else []
        words += [f"{self.control} control"] if self.control != "default" else []
        words += [f"sensor {self.sensor}"] if self.sensor else []
        words += [f"{self.split} objects"] if self.split != "all" else []
        words += [f"{self.density:g} kg/m³"] if self.density else []
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
        """Unique name of the trial, usable as a file name."""
        text = json.dumps(dict(self.trial), sort_keys=True)
        digest = hashlib.sha256(text.encode()).hexdigest()[:KEY_LENGTH]
        return f"{self.trial['family']}_{self.trial['seed']:05d}_{digest}"


@dataclass(frozen=True)
class SceneOutcome:
    """The outcome of a scene: a result, a fault, or a machine failure."""

    result: Mapping[str, Any] = field(default_factory=dict)
    """Fields of the trial's result; empty after a fault."""
    fault: str = ""
    """Exception of the trial. The scene counts as not cleared."""
    lost: str = ""
    """Reason of a machine failure (killed, out of memory, timeout). The scene is not counted and
    runs again."""


def scene_jobs(
    conditions: Iterable[Condition], seeds: Iterable[int], objects: int, extras: Mapping[str, Any]
) -> list[SceneJob]:
    """List the scenes of all conditions, seed by seed.

    All conditions share the same seeds. A run that is stopped early has equally many of each.

    Parameters
    ----------
    conditions
        Rows of the table.
    seeds
        Seeds of the scenes of each condition.
    objects
        Number of objects of a scene. A single scene has one.
    extras
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
                **extras,
            },
        )
        for seed in seeds
        for condition in rows
    ]


def attempt(run: RunTrial, trial: Mapping[str, Any]) -> SceneOutcome:
    """Run a trial. An exception becomes a fault with its source line.

    An exception of the machine is not a fault of the trial: the scene then has no outcome.
    """
    try:
        result = run(dict(trial))
        # Convert here: a value that is not plain would fail later, far from its cause.
        return SceneOutcome(result=json.loads(json.dumps(result, default=_plain)))
    except MACHINE_FAULTS as error:
        return SceneOutcome(lost=_describe(error))
    except Exception as error:
        return SceneOutcome(fault=_describe(error))
    finally:
        return_freed_memory()


def run_grasp_trial(trial: dict[str, Any]) -> dict[str, Any]:
    """Clear a scene with the simulated robot and return the fields of the result."""
    module = importlib.import_module(TRIAL_MODULE)
    prepare_grasping()
    result = module.run_trial(module.GraspTrial(**trial))
    own = {f.name: getattr(result, f.name) for f in fields(result) if f.name != "trial"}
    return {**own, "picks": [asdict(pick) for pick in result.picks]}


@cache
def prepare_grasping() -> None:
    """Load the kernels once per process, before times are measured."""
    from ..warm_up import warm_up_grasping

    warm_up_grasping()


PREPARATIONS: dict[RunTrial, Callable[[], object]] = {run_grasp_trial: prepare_grasping}
"""What a process runs once before its first trial, by the function that runs the trials."""


def _describe(error: Exception) -> str:
    message = " ".join(str(error).split())
    steps = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(steps[-1].filename).name}:{steps[-1].lineno})" if steps else ""
    return (
        f"{type(error).__name__}: {message}{place}" if message else f"{type(error).__name__}{place}"
    )


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    raise TypeError(f"a trial's result must be plain numbers and text, got {type(value).__name__}")
