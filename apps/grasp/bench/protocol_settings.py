"""Settings of a run of the clutter-removal protocol."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from eyehand.data_synth.scenes import Split
from eyehand.errors import InputError

QUICK_ROUNDS = 1
"""Maximum number of rounds of a quick run."""
PROTOCOL_COUNT = 5
"""Number of objects of a round of the original protocol."""


@dataclass(frozen=True)
class ProtocolChoice:
    """Options of `chart grasp` that choose the objects and the public protocol."""

    protocol: Literal["own", "clutter-removal"] = "own"
    """clutter-removal: chart the planning time of a gripper against success in the public protocol
    of VGN and GIGA. It uses --seed, --family (packed, pile), --jobs and the options below."""
    rounds: int = 20
    """Rounds of the protocol at each setting of the planner."""
    noise: Literal["none", "dex"] = "dex"
    """Noise of its depth image."""
    known_table: bool = False
    """Correct scale and tilt of its image from the known height of the table."""
    objects: Path | None = None
    """Folder of meshes (.obj, .stl) or URDFs to draw the objects from, instead of solids. The
    public protocol also takes a folder with the subfolders packed and pile."""
    split: Literal["all", "development", "held-out"] = "all"
    """Objects of the folder: all, or one half by their names."""
    hand: str = "panda"
    """Built-in gripper or .json file."""

    def settings(
        self, family: str, seed: int, jobs: int | None, *, quick: bool
    ) -> ProtocolSettings:
        """Return the settings of the run.

        Raises
        ------
        InputError
            If there is no folder of objects.
        """
        return ProtocolSettings(
            (family,),
            (self.noise,),
            min(self.rounds, QUICK_ROUNDS) if quick else self.rounds,
            seed,
            checked_objects(self.objects),
            self.hand,
            self.known_table,
            self.split,
            jobs,
        )


@dataclass(frozen=True)
class ProtocolSettings:
    """The rows, seeds and objects of a run of the protocol."""

    families: tuple[str, ...]
    """packed, pile."""
    noises: tuple[Literal["none", "dex"], ...]
    """none, dex."""
    rounds: int
    """Rounds of each row."""
    seed: int
    """Seed of the first round."""
    objects: Path
    """Folder with the subfolders packed and pile, or with the objects of one family."""
    hand: str = "panda"
    """Name or file of the hand."""
    known_table: bool = False
    """Whether the depth is corrected from the known height of the table."""
    split: Split = "all"
    """Which half of the objects is used."""
    jobs: int | None = None
    """Number of processes; None for the number of cores."""
    learned_table: bool = False
    """Whether the images of a round are scaled to the mean height of the table in them."""
    safe_only: bool = False
    """Whether only safe grasps are executed."""
    misplaced: tuple[float, float] = (0.0, 0.0)
    """Error of the hand's place, mm, and of its orientation, degrees, of each grasp."""
    count: int = PROTOCOL_COUNT
    """Number of objects of a round. Fewer stand in a packed scene if they do not fit."""
    density: float | None = None
    """Mass over volume of the objects, kg/m³; None for the masses of the files."""


def checked_objects(objects: Path | None) -> Path:
    """Return the folder of objects.

    Raises
    ------
    InputError
        If there is none.
    """
    if objects is None:
        raise InputError(
            "the clutter-removal protocol needs --objects FOLDER with meshes or URDFs, such as the "
            "folder that holds packed/ and pile/"
        )
    return objects
