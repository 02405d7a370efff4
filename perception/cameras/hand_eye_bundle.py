"""The bundle adjustment of a hand-eye calibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import RigidTransform

from ..frame import CameraIntrinsics
from .calibration_board import BoardView

START_SIGMAS = (0.3, 0.5e-3, np.deg2rad(0.05))
"""First guess of the errors of a corner (px) and of a robot pose (m, rad). The residuals replace
it."""
MIN_SIGMAS = (0.02, 1e-5, 1e-5)
"""Least errors that the residuals can replace them by: exact data must not end the iteration."""
ROUNDS = 4
"""Rounds in which poses and errors are estimated in turn. The errors change by 1 % in the last."""
COST_TOLERANCE = 1e-5
"""Relative change of the cost that ends a descent. With 400 corners, half the sum of squares then
changes by 0.004, which is less than 0.1 standard deviations of the pose."""
SCALE_PRIOR = 0.5
"""Standard deviation of the board's scale before the images are used. It keeps the normal
equations regular if the images do not determine the scale."""
MAX_EVALUATIONS = 25
"""Maximum evaluations of the residuals in a descent. Poses that fit need fewer; poses that do not
fit would continue for seconds without an effect on the result."""
DIFFERENCE = 1e-6
"""Step of a difference, m and rad."""


@dataclass(frozen=True, eq=False)
class BundleResult:
    """A solution of the bundle adjustment."""

    camera: RigidTransform
    board: RigidTransform
    corrections: NDArray[np.float64]
    position_error: float
    angle_error: float
    sigmas: tuple[float, float, float]
    scale: float
    """True size of the board divided by its given size; 1 if it was not estimated."""
    scale_error: float
    """Standard deviation of the scale; infinite if it was not estimated."""


@dataclass(frozen=True, eq=False)
class _Start:
    """The constant inputs of a descent. Plain matrices multiply faster than pose objects."""

    camera: NDArray[np.float64]
    """Pose of the camera at the start, (4, 4)."""
    board: NDArray[np.float64]
    """Pose of the board at the start, (4, 4)."""
    wrist: NDArray[np.float64]
    """Poses of the robot, (N, 4, 4)."""
    image: NDArray[np.intp]
    """Index of the image of each corner, (M,)."""
    points: NDArray[np.float64]
    """Corners in the frame of the board, (M, 3), m."""
    pixels: NDArray[np.float64]
    """Corners in the images, (M, 2)."""


@dataclass(frozen=True, eq=False)
class Bundle:
    """The bundle adjustment of all images."""

    views: Sequence[BoardView]
    wrist_poses: RigidTransform
    intrinsics: CameraIntrinsics
    on_wrist: bool
    """Whether the wrist carries the camera, and not the board."""

    def solve(
        self,
        used: list[int],
        camera: RigidTransform,
        board: RigidTransform,
        free_scale: bool = False,
    ) -> BundleResult:
        """Estimate poses and errors in turn, from a start.

        The unknowns are twists (rotation vector, translation) that correct the start: 6 of the
        camera, 6 of the board, 6 of each robot pose. With `free_scale` the last unknown is the
        correction of the board's scale.
        """
        sigmas = START_SIGMAS
        last = 12 + 6 * len(used)
        start = self._start(used, camera, board)
        result = self._descend(np.zeros(last + free_scale), start, sigmas)
        for _ in range(ROUNDS - 1):
            sigmas = self._sigmas(result.fun, result.jac, len(used), sigmas)
            result = self._descend(result.x, start, sigmas)
        unknown = result.x
        covariance = np.linalg.pinv(result.jac.T @ result.jac)
        corrections = unknown[12:last].reshape(-1, 6)
        moves = _exponentials(unknown[:12].reshape(2, 6))
        norms = np.linalg.norm(corrections.reshape(-1, 2, 3), axis=2)
        return BundleResult(
            camera=RigidTransform.from_matrix(start.camera @ moves[0]),
            board=RigidTransform.from_matrix(start.board @ moves[1]),
            corrections=norms[:, ::-1],
            position_error=float(np.sqrt(np.trace(covariance[3:6, 3:6]))),
            angle_error=float(np.sqrt(np.trace(covariance[:3, :3]))),
            sigmas=sigmas,
            scale=1.0 + float(unknown[last]) if free_scale else 1.0,
            scale_error=float(np.sqrt(covariance[last, last])) if free_scale else np.inf,
        )

    def _start(self, used: list[int], camera: RigidTransform, board: RigidTransform) -> _Start:
        return _Start(
            camera.as_matrix(),
            board.as_matrix(),
            self.wrist_poses[used].as_matrix(),
            np.repeat(np.arange(len(used)), [len(self.views[i].points) for i in used]),
            np.concatenate([self.views[i].points for i in used]),
            np.concatenate([self.views[i].pixels for i in used]),
        )

    def _descend(
        self, unknown: NDArray[np.float64], start: _Start, sigmas: tuple[float, float, float]
    ) -> Any:
        """Minimise the residuals by Levenberg-Marquardt, and return SciPy's result."""
        jacobian = cast("Any", self._jacobian)  # SciPy's types know only the named differences
        return least_squares(
            self._residuals,
            unknown,
            jacobian,
            args=(start, sigmas),
            method="lm",
            ftol=COST_TOLERANCE,
            max_nfev=MAX_EVALUATIONS,
        )

    def _residuals(
        self, unknown: NDArray[np.float64], start: _Start, sigmas: tuple[float, float, float]
    ) -> NDArray[np.float64]:
        """Return errors of all corners, the corrections, and the change of a free scale.

        Each is divided by its deviation.
        """
        last = 12 + 6 * len(start.wrist)
        twists, scale = unknown[:last].reshape(-1, 6), unknown[last:]
        moves = _exponentials(twists)
        T_x_camera, T_y_board = start.camera @ moves[0], start.board @ moves[1]
        # A camera on the wrist sees the board through (world, wrist, camera), one in the world
        # through (camera, world, wrist).
        wrist = start.wrist @ moves[2:]
        if self.on_wrist:
            T_camera_board = _inverses(wrist @ T_x_camera) @ T_y_board
        else:
            T_camera_board = _inverses(T_x_camera) @ wrist @ T_y_board
        matrices, points = T_camera_board[start.image], start.points * (1.0 + scale.sum())
        x, y, z = (np.einsum("nij,nj->ni", matrices[:, :3, :3], points) + matrices[:, :3, 3]).T
        k = self.intrinsics
        projected = np.column_stack([k.fx * x / z + k.cx, k.fy * y / z + k.cy])
        return np.concatenate(
            [
                (projected - start.pixels).ravel() / sigmas[0],
                (twists[2:] / _pose_sigmas(sigmas)).ravel(),
                scale / SCALE_PRIOR,
            ]
        )

    def _jacobian(
        self, unknown: NDArray[np.float64], start: _Start, sigmas: tuple[float, float, float]
    ) -> NDArray[np.float64]:
        """Return central differences of `_residuals`.

        A correction changes only the corners of its own image. The corrections of all images
        move at once, so that 18 differences give all columns, and one more that of the scale.
        """
        images = np.arange(len(start.wrist))
        owner = np.concatenate([np.repeat(start.image, 2), np.repeat(images, 6)])
        last = 12 + 6 * len(images)
        own = np.arange(len(owner))
        jacobian = np.zeros((len(owner) + len(unknown) - last, len(unknown)))
        for column in [*range(18), *range(last, len(unknown))]:
            moved = np.zeros(len(unknown))
            shared = column < 12 or column == last
            moved[column if shared else slice(column, last, 6)] = DIFFERENCE
            change = self._residuals(unknown + moved, start, sigmas)
            change -= self._residuals(unknown - moved, start, sigmas)
            change /= 2 * DIFFERENCE
            if shared:
                jacobian[:, column] = change
            else:
                jacobian[own, column + 6 * owner] = change[own]
        return jacobian

    def _sigmas(
        self,
        residuals: NDArray[np.float64],
        jacobian: NDArray[np.float64],
        images: int,
        sigmas: tuple[float, float, float],
    ) -> tuple[float, float, float]:
        """Estimate the errors from the residuals of each kind.

        The redundancy of a residual, 1 minus its leverage, is the share of an error that remains
        visible in it (Förstner, "Ein Verfahren zur Schätzung von Varianz- und
        Kovarianzkomponenten", 1979).
        """
        normal = np.linalg.pinv(jacobian.T @ jacobian)
        redundancy = 1.0 - ((jacobian @ normal) * jacobian).sum(axis=1)
        end = len(residuals) - (jacobian.shape[1] - 12 - 6 * images)
        residuals, redundancy = residuals[:end], redundancy[:end]  # without the prior of the scale
        turns = np.zeros(end, bool)
        turns[-6 * images :] = np.tile([True] * 3 + [False] * 3, images)
        shifts = np.zeros(end, bool)
        shifts[-6 * images :] = ~turns[-6 * images :]
        estimated = []
        for kind, sigma, least in zip(
            (~(turns | shifts), shifts, turns), sigmas, MIN_SIGMAS, strict=True
        ):
            free = max(float(redundancy[kind].sum()), 1.0)
            factor = np.sqrt(float(residuals[kind] @ residuals[kind]) / free)
            estimated.append(max(sigma * factor, least))
        return estimated[0], estimated[1], estimated[2]


def _exponentials(twists: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrices (N, 4, 4) of poses from rotation vectors and translations, (N, 6)."""
    turns = twists[:, :3]
    angles = np.sqrt((turns * turns).sum(axis=1))[:, None, None]
    x, y, z = turns.T
    cross = np.zeros((len(twists), 3, 3))
    cross[:, 2, 1], cross[:, 0, 2], cross[:, 1, 0] = x, y, z
    cross -= cross.transpose(0, 2, 1)
    # Rodrigues' formula; sinc(a / pi) is sin(a) / a.
    half = np.sinc(angles / (2.0 * np.pi))
    moves = np.tile(np.eye(4), (len(twists), 1, 1))
    moves[:, :3, :3] += np.sinc(angles / np.pi) * cross + 0.5 * half * half * (cross @ cross)
    moves[:, :3, 3] = twists[:, 3:]
    return moves


def _inverses(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inverse of matrices of poses, (..., 4, 4)."""
    inverses = np.zeros_like(poses)
    inverses[..., :3, :3] = poses[..., :3, :3].swapaxes(-1, -2)
    inverses[..., :3, 3:] = -inverses[..., :3, :3] @ poses[..., :3, 3:]
    inverses[..., 3, 3] = 1.0
    return inverses


def _pose_sigmas(sigmas: tuple[float, float, float]) -> NDArray[np.float64]:
    return np.repeat([sigmas[2], sigmas[1]], 3)
