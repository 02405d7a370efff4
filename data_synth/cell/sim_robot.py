"""The simulated robot: arm, hand, fingertips and depth camera. It implements the robot protocol."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.grasping import ParallelHand, RobotReading
from eyehand.perception import CameraIntrinsics, DepthFrame, mask_points, mask_robot

from ..mujoco_import import import_mujoco
from ..render.depth_noise import DepthNoise, add_depth_noise
from ..render.depth_renderer import DEFAULT_MAX_RANGE_M, open_renderer
from ..scenes.viewpoint import look_at
from .arm_servos import ArmServos
from .cell_appearance import DISPLAY_EYE, DISPLAY_FOCAL_SHARE, DISPLAY_TARGET
from .contact_record import ContactRecord
from .fingertip_pads import find_tips
from .grasp_cell import add_pedestal
from .grasp_world import ROBOT_PREFIX, GraspWorld
from .hand_touch import HandTouch
from .robot_faults import command_fault, simulation_fault
from .wrist_sensor import WristSensor

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.grasping import HandModel
    from eyehand.grasping.hands import AnyCommand, AnyReading

    from ..pad import SensorModel
    from ..render.rendered_view import DepthRenderer

PERIOD_S = 0.004
"""Control period, s. It must be a multiple of the physics step."""

_MAX_HEIGHT_IN_TRAY_M = 0.3
"""Maximum height of the centre of an object in the tray above the tray's floor, m."""


class SimRobot:
    """A robot in a simulated cell. It implements `eyehand.grasping.robot.Robot`.

    It starts at rest with the hand open. :meth:`object_pose`, :meth:`take_contacts`,
    :meth:`is_lifted` and :meth:`is_in_tray` return the ground truth, which a real robot does not
    have.

    Parameters
    ----------
    world
        The world in which it runs.
    noise
        Noise of the camera. If None, the depth is exact.
    seed
        Seed of the camera noise, >= 0. Each image has different noise.
    renderer
        Renderer of the camera. If None, `open_renderer` selects one.
    hand
        Model of the hand. If None, it is computed from the hand's description.
    sensor
        Sensor model of the hand's pads. If None, touch is exact.

    Raises
    ------
    InputError
        If the seed is negative, a joint of the arm has no servo, MuJoCo cannot simulate the world,
        or a gripper with jaws gets a sensor model.
    """

    def __init__(
        self,
        world: GraspWorld,
        *,
        noise: DepthNoise | None = None,
        seed: int = 0,
        renderer: DepthRenderer | None = None,
        hand: HandModel | ParallelHand | None = None,
        sensor: SensorModel | None = None,
    ) -> None:
        if seed < 0:
            raise InputError(f"seed must be a whole number >= 0, got {seed}")
        self._mujoco = mujoco = import_mujoco()
        self._world, self._noise, self._renderer = world, noise or DepthNoise.none(), renderer
        self._seed, self._captures = seed, 0
        self._model = model = world.copy_model()
        self._data = data = mujoco.MjData(model)
        self._hand = hand or world.robot.measured_hand()
        self._steps = round(PERIOD_S / model.opt.timestep)
        joints = [ROBOT_PREFIX + name for name in world.robot.joints]
        self._servos = ArmServos(model, data, joints, world.robot.home)
        self._open_hand()
        self._drives = world.robot.create_drives(model, data, world.hand_prefix)
        fingers = () if isinstance(self._hand, ParallelHand) else self._hand.fingers
        self._tips, on_pads = find_tips(model, world.hand_prefix, fingers)
        self._sensor = HandTouch(sensor, self._hand, on_pads, seed) if sensor else None
        self._touch = ContactRecord(model, data, world)
        self._wrist = WristSensor(model, data, ROBOT_PREFIX + world.robot.frame, seed)
        self._saved_state = np.empty(
            mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_INTEGRATION)
        )
        self._fault = ""
        try:
            mujoco.mj_forward(model, data)
        except mujoco.FatalError as error:
            reason = " ".join(str(error).split())
            raise InputError(f"MuJoCo cannot run a cell with this robot: {reason}") from None
        self._sense()

    @property
    def hand(self) -> HandModel | ParallelHand:
        """Model of the hand."""
        return self._hand

    @property
    def period(self) -> float:
        """Control period, s."""
        return PERIOD_S

    @property
    def hand_frame(self) -> str:
        """Name of the hand's frame in the robot description (`description`)."""
        return self._world.robot.frame

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the arm's joints in the description."""
        return self._world.robot.joints

    @property
    def world(self) -> GraspWorld:
        """The world in which the robot runs."""
        return self._world

    @property
    def model(self) -> Any:
        """The `mujoco.MjModel` of the simulation."""
        return self._model

    @property
    def data(self) -> Any:
        """The state, `mujoco.MjData`; read only."""
        return self._data

    def description(self, posture: NDArray[np.float64]) -> Any:
        """Return the `MjSpec` of arm, hand and pedestal for the controller.

        Its keyframe ``home`` holds the hand's joints at tendon excursions (D,) or a width (1,), m.
        """
        robot = self._world.robot
        spec = robot.description(robot.home, posture, self._world.cell.T_world_base)
        add_pedestal(spec, self._world.cell)
        return spec

    def read(self) -> RobotReading:
        """Return the current state."""
        hand = self.exact_hand_reading()
        return RobotReading(
            float(self._data.time),
            self._servos.positions(),
            self._servos.speeds(),
            hand if self._sensor is None else self._sensor.touched(hand),
            self._fault,
            self._wrist.wrench,
        )

    def exact_hand_reading(self) -> AnyReading:
        """Return the hand's reading with exact forces and images."""
        return self._drives.reading(self._tips.read(self._data))

    def step(
        self, velocity: NDArray[np.float64], command: AnyCommand | None = None
    ) -> RobotReading:
        """Move for one control period and return the state at its end.

        After a command that is not finite, or after a failure of MuJoCo, the simulation stops: the
        time and all objects stand still. `RobotReading.fault` then holds the reason.

        Parameters
        ----------
        velocity
            Joint velocities of the arm, (n,), rad/s. They are limited to the joints' speeds and
            ranges.
        command
            Command for the hand's drives. None keeps the previous command.

        Raises
        ------
        InputError
            If a shape is wrong.
        """
        velocity = np.asarray(velocity, dtype=np.float64)
        if velocity.shape != (len(self.joints),):
            raise InputError(f"velocity must be ({len(self.joints)},), got {velocity.shape}")
        if not self._fault:
            self._fault = command_fault(velocity, command)
        if self._fault:
            return self.read()
        mujoco, model, data = self._mujoco, self._model, self._data
        if command is not None:
            self._drives.command(command)
        whole = mujoco.mjtState.mjSTATE_INTEGRATION
        mujoco.mj_getState(model, data, self._saved_state, whole)
        for _ in range(self._steps):
            self._servos.apply(velocity)
            self._drives.apply()
            mujoco.mj_step(model, data)
            self._touch.record()
        self._wrist.measure()
        self._sense()
        self._fault = simulation_fault(data)
        if self._fault:
            mujoco.mj_setState(model, data, self._saved_state, whole)
            mujoco.mj_forward(model, data)
        return self.read()

    def capture(self) -> DepthFrame:
        """Capture a depth image. Pixels of the robot's pedestal and the tray have no reading."""
        cell, model = self._world.cell, self._model
        labels = np.zeros(model.ngeom, dtype=np.int32)
        fixed = model.body_weldid[model.geom_bodyid] == 0
        labels[self._touch.robot & fixed] = 1
        view = self._render(cell.intrinsics, cell.T_world_camera, labels, colour=False)
        rng = np.random.default_rng([self._seed, self._captures])
        self._captures += 1
        depth = add_depth_noise(view.depth, cell.intrinsics, rng, self._noise)
        frame = DepthFrame(depth, cell.intrinsics, cell.T_world_camera)
        return mask_points(mask_robot(frame, view.labels == 1), self._world.is_near_tray)

    def picture(
        self, size: tuple[int, int] = (1280, 720), T_world_camera: RigidTransform | None = None
    ) -> NDArray[np.uint8]:
        """Render a colour image of the cell for display.

        Parameters
        ----------
        size
            Columns and rows, px.
        T_world_camera
            Camera pose (x right, y down, z forward); in front of the table if None.

        Returns
        -------
        NDArray
            (H, W, 3) uint8 RGB.
        """
        width, height = size
        focal = DISPLAY_FOCAL_SHARE * width
        intrinsics = CameraIntrinsics(
            focal, focal, (width - 1) / 2, (height - 1) / 2, width, height
        )
        if T_world_camera is None:
            T_world_camera = look_at(DISPLAY_EYE, DISPLAY_TARGET)
        labels = np.zeros(self._model.ngeom, np.int32)
        colour = self._render(intrinsics, T_world_camera, labels, colour=True).colour
        assert colour is not None
        return colour

    def object_pose(self, name: str) -> RigidTransform:
        """Return the true pose of an object, T_world_object."""
        body = self._data.body(self._checked_name(name))
        rotation = Rotation.from_quat(body.xquat, scalar_first=True)
        return RigidTransform.from_components(body.xpos.copy(), rotation)

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the objects in the world."""
        return self._world.object_names

    def mass(self, name: str) -> float:
        """Return the mass of an object, kg."""
        return float(self._model.body_mass[self._model.body(self._checked_name(name)).id])

    def set_load(self, name: str, force: float) -> None:
        """Pull an object down with a force, N, until the next call; 0 ends it."""
        body = self._model.body(self._checked_name(name)).id
        self._data.xfrc_applied[body] = (0.0, 0.0, -force, 0.0, 0.0, 0.0)

    def take_contacts(self) -> set[str]:
        """Return the names of what the robot touched since the last call, and clear the record.

        The names are "table" (which includes the floor), "tray", "pedestal" and those of objects.
        """
        return self._touch.take_touched()

    def is_lifted(self, name: str) -> bool:
        """Return whether an object touches the robot and nothing else."""
        touching = self._touch.touching(self._checked_name(name))
        return touching == {"robot"}

    def is_in_tray(self, name: str) -> bool:
        """Return whether an object lies in the tray and not in the hand."""
        position = self._data.body(self._checked_name(name)).xpos
        cell = self._world.cell
        low = position[2] - cell.tray_centre[2] < _MAX_HEIGHT_IN_TRAY_M
        held = "robot" in self._touch.touching(name)
        return bool(low and cell.is_over_tray(position) and not held)

    def _sense(self) -> None:
        """Take an image of the hand's pads, if a sensor model reads them."""
        if self._sensor is not None:
            self._sensor.sense(self.exact_hand_reading(), self._data, self._tips)

    def _open_hand(self) -> None:
        robot = self._world.robot
        for name, angle in zip(robot.hand_joints, robot.open_posture, strict=True):
            self._data.joint(ROBOT_PREFIX + name).qpos[0] = angle

    def _render(
        self, intrinsics: CameraIntrinsics, T_world_camera: RigidTransform, labels: NDArray,
        *, colour: bool,
    ) -> Any:  # fmt: skip
        renderer = self._renderer or open_renderer()
        return renderer.render(
            self._model,
            self._data,
            intrinsics,
            T_world_camera,
            labels,
            max_range=DEFAULT_MAX_RANGE_M,
            colour=colour,
        )

    def _checked_name(self, name: str) -> str:
        if name not in self.object_names:
            names = ", ".join(self.object_names) or "none"
            raise InputError(f"object must be one of {names}, got {name!r}")
        return name
