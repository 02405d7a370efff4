"""Options of a command that choose the simulated robot: by name, by files, or described by hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from eyehand.errors import InputError

from ..frame_masks import Numbers


@dataclass(frozen=True)
class RobotChoice:
    """Options that choose the robot."""

    arm: str = ""
    """Arm: lbr (the default, included), panda, ur5e, iiwa14, or an MJCF file. EYEHAND_ROBOTS names
    the folder of the files; otherwise the package mujoco-menagerie downloads them."""
    hand: str = ""
    """Hand: own (the default of lbr, included), panda, 2f85, allegro, or an MJCF file of a gripper
    or a hand of fingers. Default: the arm's own hand."""
    mount: Numbers = None
    """Pose of the hand's file in the arm's flange, where no default is known: x y z in m, roll
    pitch yaw in rad."""
    robot: Path | None = None
    """MJCF file of an arm with a hand of several fingers. For a hand whose motors drive joints,
    robot.hand.json beside robot.xml describes the fingers."""
    hand_frame: str = ""
    """With --robot: the site or body in the palm. Its z axis points out of the palm, its x axis
    from the fingers to the thumb."""

    def trial_fields(self) -> dict[str, Any]:
        """Return the fields of a trial for the robot, with absolute paths.

        Raises
        ------
        InputError
            If options exclude each other, a file is missing, or the robot cannot be built.
        """
        if (self.robot is None) != (not self.hand_frame):
            raise InputError("--robot FILE and --hand-frame NAME go together: give both")
        if self.robot is not None and (self.arm or self.hand):
            raise InputError("--robot FILE excludes --arm and --hand: give either")
        if self.robot is not None and not self.robot.is_file():
            raise InputError(f"--robot {self.robot}: no such file, expected an MJCF file")
        fields: dict[str, Any] = {
            "robot": "" if self.robot is None else str(self.robot.resolve()),
            "hand_frame": self.hand_frame,
            "arm": _absolute(self.arm),
            "hand": _absolute(self.hand),
            "mount": " ".join(f"{number:.10g}" for number in self.mount or ()),
        }
        if self.mount is not None and not (self.arm or self.hand):
            raise InputError("--mount needs --arm and --hand")
        if self.robot is not None or self.arm or self.hand:
            from .bench.trial import GraspTrial, trial_cell

            trial_cell((), GraspTrial(**fields))
        return fields


def _absolute(name: str) -> str:
    """Return a name, or the absolute path of a file."""
    return str(Path(name).resolve()) if Path(name).is_file() else name
