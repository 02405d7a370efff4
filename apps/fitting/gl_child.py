"""A child process that draws by OpenGL, where a crash does no harm.

VTK crashes rather than fails where no driver is, and where one is it closes the EGL display that
MuJoCo's renderer holds in the same process. In a process of its own it does neither.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import threading
from typing import TYPE_CHECKING

from eyehand.data_synth.render import gl_module

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from .picture_parts import PictureScene

TIMEOUT_S = 60.0
"""Longest wait for one scene; the first takes some 4 s, further ones less than 1 s."""
_PROGRAM = "from eyehand.apps.fitting.gl_panels import serve; serve()"


class GlChild:
    """Draws scenes while the block lasts; gives None from the first failure on.

    Parameters
    ----------
    program
        Python program of the child.
    """

    def __init__(self, program: str = _PROGRAM) -> None:
        self._program = program
        self._process: subprocess.Popen[bytes] | None = None
        self._failed = False

    def __enter__(self) -> GlChild:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def panels(self, scene: PictureScene) -> Sequence[Sequence[NDArray[np.uint8]]] | None:
        """Draw a scene (see :func:`gl_panels`), or give None where that cannot be done.

        `MUJOCO_GL=disable` forbids it, as it does for MuJoCo's renderer.
        """
        if self._failed or gl_module() is None:
            return None
        try:
            return self._ask(scene)
        except (OSError, EOFError, pickle.UnpicklingError):
            self._failed = True
            self._end()
            return None

    def _ask(self, scene: PictureScene) -> Sequence[Sequence[NDArray[np.uint8]]]:
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-c", self._program],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        # A driver that hangs is as bad as one that crashes.
        patience = threading.Timer(TIMEOUT_S, process.kill)
        patience.start()
        try:
            pickle.dump(scene, process.stdin)
            process.stdin.flush()
            return pickle.load(process.stdout)
        finally:
            patience.cancel()

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        # It has nothing to lose, and VTK takes its time to say good-bye.
        process.kill()
        process.communicate()
