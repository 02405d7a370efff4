"""The robot of a grasping cell as a MuJoCo description: an arm with a hand on its flange."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from ..arms import HAND, HOME_KEY, LBR_ARM, PALM_BEFORE_FLANGE_M, TOOL_SITE
from ..mujoco_import import import_mujoco
from .arm_check import check_arm, check_file_format, check_rest_posture
from .hand_description import DESCRIPTION_SUFFIX, EXAMPLE, HandDescription, description_beside
from .hand_frame import find_frame
from .jaw_assembly import fix_base, prepare_jaws
from .jaw_drives import JawDrives, create_jaw_drives
from .jaw_mechanism import JawMechanism, find_jaws, name_parts
from .pad_friction import grip_pads
from .robot_file import compile_robot, read_robot
from .spec_assembly import match_options, prepare_for_attachment, remove_visual_geoms, set_base
from .synergy_drives import SynergyDrives
from .synergy_hand_model import synergy_hand_model
from .tendon_drives import TendonDrives
from .tendon_geometry import joint_springs, moment_arms, tendon_posture
from .tendon_hand_model import PALM_SITE, tendon_hand_model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.grasping import HandModel, ParallelHand

    from .tendon_geometry import Springs

HAND_PREFIX = "hand_"
"""Prefix of the names of a hand attached to an arm."""
REST_POSTURE = (-0.42, -0.04, 0.0, -1.87, 0.0, 1.31, -1.99)
"""Joint angles of the LBR at rest in the cell, rad: beside the work area, outside the image."""


@dataclass(frozen=True)
class GraspRobot:
    """An arm with a hand, in one MJCF file or two.

    Raises
    ------
    InputError
        If a file cannot be read, or it lacks the flange or the hand's frame.
    """

    arm: Path = LBR_ARM
    """MJCF file of the arm, or of the whole robot."""
    hand: Path | None = HAND
    """MJCF file of the hand; None if the arm's file contains the hand."""
    frame: str = HAND_PREFIX + PALM_SITE
    """Site or body that is the hand's frame: origin in the palm's face, z out of it, x from the
    fingers to the thumb."""
    flange: str = TOOL_SITE
    """Site of the arm that carries the hand, its z-axis out of the flange."""
    rest: tuple[float, ...] | None = None
    """Arm joint angles at rest, rad; None means `REST_POSTURE` for the LBR-like arm, and the
    keyframe ``home`` for others."""
    fingers: HandDescription | None = None
    """Joints of each finger of a hand with joint motors; None for a tendon hand."""
    jaws: ParallelHand | None = None
    """Gripper with two jaws; None for a hand with fingers. The frame is then its tool frame."""
    mount: RigidTransform | None = None
    """Pose of the hand's file in the flange, T_flange_hand; None for the default."""

    @classmethod
    def of_file(cls, path: Path, frame: str) -> GraspRobot:
        """Read a whole robot from one MJCF file, and its hand description from the JSON beside it.

        Parameters
        ----------
        path
            MJCF file of arm and hand; ``robot.hand.json`` beside ``robot.xml`` describes a hand
            whose motors move joints (:func:`~.hand_description.description_beside`).
        frame
            Site or body that is the hand's frame.

        Raises
        ------
        InputError
            If a file cannot be read, or its arm cannot move the hand.
        """
        made = cls(path, hand=None, frame=frame, fingers=description_beside(path))
        path, model = Path(path), made._model
        check_file_format(path)
        described = () if made.fingers is None else made.fingers.fingers
        finger_joints = tuple(joint for finger in described for joint in finger.joints)
        check_arm(path, model, made.joints, made.hand_joints, finger_joints, frame)
        check_rest_posture(path, model, made.joints, made.home)
        return made

    @functools.cached_property
    def joints(self) -> tuple[str, ...]:
        """Names of the arm's joints, from base to tip."""
        model = self._model
        body, _ = find_frame(model, self.frame)
        names = []
        while body > 0:
            first = model.body_jntadr[body]
            names += [model.joint(first + k).name for k in range(model.body_jntnum[body])][::-1]
            body = model.body_parentid[body]
        if self.hand is not None:
            names = [name for name in names if not name.startswith(HAND_PREFIX)]
        # The wrist of a hand lies between its palm and the arm.
        still = () if self.fingers is None else self.fingers.still
        return tuple(name for name in names[::-1] if name not in still)

    @functools.cached_property
    def hand_joints(self) -> tuple[str, ...]:
        """Names of the hand's joints, in the order of its file."""
        model, arm = self._model, set(self.joints)
        return tuple(n for n in (model.joint(j).name for j in range(model.njnt)) if n not in arm)

    @functools.cached_property
    def drives(self) -> tuple[str, ...]:
        """Names of the tendons in the order of the file; names of the fingers if it has none."""
        if self.jaws is not None:
            return ("width",)
        if self.fingers is not None:
            return tuple(finger.name for finger in self.fingers.fingers)
        model = self._model
        return tuple(model.tendon(tendon).name for tendon in range(model.ntendon))

    @functools.cached_property
    def home(self) -> NDArray[np.float64]:
        """Arm joint angles at rest, (n,), rad."""
        rest = REST_POSTURE if self.rest is None and self.arm == LBR_ARM else self.rest
        if rest is not None:
            if len(rest) != len(self.joints) or not np.isfinite(rest).all():
                raise InputError(
                    f"rest must be {len(self.joints)} finite angles in rad, one for each of "
                    f"{', '.join(self.joints)}; got {rest}"
                )
            return np.array(rest, dtype=np.float64)
        # Joined robots lose their keyframes.
        model = (
            self._model if self.jaws is None else compile_robot(read_robot(self.arm), f"{self.arm}")
        )
        keys = [model.key(number) for number in range(model.nkey)]
        posture = next((key.qpos for key in keys if key.name == HOME_KEY), model.qpos0)
        return posture[[model.joint(name).qposadr[0] for name in self.joints]].copy()

    @property
    def hand_prefix(self) -> str:
        """Prefix of the hand's names in :meth:`spec`; empty if the robot is one file."""
        return "" if self.hand is None else HAND_PREFIX

    def spec(self, friction: float | None = None) -> Any:
        """Describe arm and hand as an `MjSpec`, base at the world's origin, without keyframes.

        Parameters
        ----------
        friction
            Sliding friction of the whole hand; None keeps the values of its file.
        """
        spec = read_robot(self.arm)
        if self.hand is not None:
            flange = next((site for site in spec.sites if site.name == self.flange), None)
            if flange is None:
                raise InputError(f"{self.arm} has no site {self.flange!r} to carry the hand")
            hand = read_robot(self.hand)
            prepare_for_attachment(hand)
            if self.jaws is not None:
                name_parts(hand)
                fix_base(hand, self.mechanism)
            # A gripper sits on the flange, the palm of a hand with fingers before it.
            depth = PALM_BEFORE_FLANGE_M if self.jaws is None else 0.0
            default = RigidTransform.from_translation([0.0, 0.0, depth])
            set_base(hand, default if self.mount is None else self.mount)
            match_options(spec, hand)
            spec.attach(hand, prefix=HAND_PREFIX, site=flange)
        prepare_for_attachment(spec)
        if self.jaws is not None:
            name_parts(spec)
            prepare_jaws(spec, self.mechanism, friction, prefix=self.hand_prefix)
            return spec
        if friction is not None:
            for geom in spec.geoms:
                if geom.priority > 0 or geom.name.startswith(HAND_PREFIX):
                    geom.friction = [friction, *geom.friction[1:]]
        if self.fingers is not None:
            grip_pads(spec, self.fingers, friction, prefix=self.hand_prefix)
        return spec

    def posture(self, excursions: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the hand's joint angles (J,), rad, at tendon excursions (D,), m."""
        excursions = np.asarray(excursions, dtype=np.float64)
        if excursions.shape != (len(self.drives),) or not np.isfinite(excursions).all():
            raise InputError(
                f"excursions must be {len(self.drives)} finite lengths in m, one for each of "
                f"{', '.join(self.drives)}; got {excursions.tolist()}"
            )
        if self.jaws is not None:
            positions = dict(
                zip(self.mechanism.joints, self.mechanism.posture(excursions[0]), strict=True)
            )
            rest = self._model.qpos0[self._hand_addresses]
            names = [name.removeprefix(self.hand_prefix) for name in self.hand_joints]
            return np.array([positions.get(n, q) for n, q in zip(names, rest, strict=True)])
        if self.fingers is not None:
            data = import_mujoco().MjData(self._model)
            drives = SynergyDrives(self._model, data, self.fingers, prefix=self.hand_prefix)
            drives.pose(excursions)
            return data.qpos[self._hand_addresses].copy()
        moments, springs = self._tendons
        return tendon_posture(moments, excursions, *springs)

    @property
    def open_drives(self) -> NDArray[np.float64]:
        """Excursions of the open hand, (D,), m."""
        stroke = 0.0 if self.jaws is None else self.mechanism.stroke
        return np.full(len(self.drives), stroke)

    @property
    def open_posture(self) -> NDArray[np.float64]:
        """Joint angles of the open hand, (J,), rad or m."""
        return self.posture(self.open_drives)

    def create_drives(
        self, model: Any, data: Any, prefix: str
    ) -> TendonDrives | SynergyDrives | JawDrives:
        """Create the drives that execute hand commands in a world with this robot.

        Parameters
        ----------
        model, data
            `MjModel` and `MjData` of the world.
        prefix
            Prefix of the hand's names in the world.
        """
        if self.jaws is not None:
            return create_jaw_drives(model, data, self.mechanism, self.jaws, prefix=prefix)
        if self.fingers is None:
            return TendonDrives(model, data, prefix=prefix)
        return SynergyDrives(model, data, self.fingers, prefix=prefix)

    def measured_hand(self) -> HandModel | ParallelHand:
        """Measure opening widths and reach of the hand from its kinematics.

        A gripper with two jaws has its description.

        Raises
        ------
        InputError
            If no fingers close against a thumb, or the fingers are not described.
        """
        if self.jaws is not None:
            return self.jaws
        if self.fingers is not None:
            prefix = self.hand_prefix
            return synergy_hand_model(self._model, self.fingers, self.frame, prefix=prefix)
        if self.hand is not None:
            return tendon_hand_model(self.hand)
        if not self.drives:
            raise InputError(
                f"the fingers of {self.arm} are not described: describe them in "
                f"{Path(self.arm).with_suffix(DESCRIPTION_SUFFIX)}, as {EXAMPLE}"
            )
        frame = HAND_PREFIX + self.frame
        return tendon_hand_model(self._hand_alone(), frame=frame, prefix=HAND_PREFIX)

    def description(
        self, q: NDArray[np.float64], excursions: NDArray[np.float64], T_world_base: RigidTransform
    ) -> Any:
        """Describe the robot for control: an `MjSpec` with the keyframe ``home``.

        Parameters
        ----------
        q
            The arm's joint angles at home, (n,), rad.
        excursions
            Tendon excursions of the hand, (D,), m.
        T_world_base
            Pose of the robot's base.
        """
        spec = self._control_spec.copy()
        set_base(spec, T_world_base)
        posture = self._model.qpos0.copy()
        posture[self._arm_addresses] = q
        posture[self._hand_addresses] = self.posture(excursions)
        spec.add_key(name=HOME_KEY, qpos=posture)
        return spec

    def _hand_alone(self) -> Any:
        """Return the hand of a whole robot as its own spec: the frame's body and its children."""
        mujoco = import_mujoco()
        spec, alone = self.spec(), mujoco.MjSpec()
        match_options(alone, spec)
        body, _ = find_frame(self._model, self.frame)
        root = next(part for part in spec.bodies if part.name == self._model.body(body).name)
        alone.worldbody.add_frame().attach_body(root, HAND_PREFIX, "")
        return alone

    @functools.cached_property
    def mechanism(self) -> JawMechanism:
        """The jaws and their motor.

        Raises
        ------
        InputError
            If the file of the hand has no gripper.
        """
        return find_jaws(self.arm if self.hand is None else self.hand)

    def compiled(self) -> Any:
        """Return the compiled robot alone (`MjModel`), which is shared: do not change it."""
        return self._model

    @functools.cached_property
    def _model(self) -> Any:
        whole = self.hand is None and self.jaws is None
        spec = read_robot(self.arm) if whole else self.spec()
        files = f"{self.arm} with {self.hand}" if self.hand is not None else f"{self.arm}"
        return compile_robot(spec, files)

    @functools.cached_property
    def _control_spec(self) -> Any:
        """The robot without visual geoms, which compiles faster."""
        spec = self.spec()
        remove_visual_geoms(spec, self._model if self.jaws is not None else None)
        return spec

    @functools.cached_property
    def _arm_addresses(self) -> NDArray[np.intp]:
        return np.array([self._model.joint(name).qposadr[0] for name in self.joints])

    @functools.cached_property
    def _tendons(self) -> tuple[NDArray[np.float64], Springs]:
        """Moment arms of the hand's tendons, (D, J), and the springs of its joints."""
        springs = joint_springs(self._model, self.hand_joints)
        return moment_arms(self._model, self.drives, self.hand_joints, springs), springs

    @functools.cached_property
    def _hand_addresses(self) -> NDArray[np.intp]:
        return np.array([self._model.joint(n).qposadr[0] for n in self.hand_joints], dtype=np.intp)
