"""The options of `eyehand evaluate fit` that choose meshes and their views."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from eyehand.errors import InputError

from .mesh_views import ELEVATIONS, FACE_ON, NoiseName

HalfName = Literal["settings", "report", "all"]
"""Half of the meshes to use."""


@dataclass(frozen=True)
class MeshData:
    """Views of household meshes to evaluate the fit on."""

    meshes: tuple[Path, ...] = ()
    """Folders of OBJ, STL or PLY meshes in m. With them the fit is evaluated on views of the
    meshes on a table, in place of the clouds."""
    views: tuple[str, ...] = tuple(f"{value:g}" for value in ELEVATIONS)
    """Elevations of the camera, degrees, or "face" for a view along the normal of the largest
    face."""
    noise: NoiseName = "1mm"
    """Noise of the camera at the object, or that of a structured-light camera."""
    poses: int = 1
    """Maximum number of resting poses per mesh; the first is the one nearest to the file's."""
    neighbours: bool = False
    """Set three other meshes beside each one, and perceive the scene without any knowledge."""
    hidden: tuple[float, ...] = ()
    """Shares of the rows or columns of an object, %, that something nearer hides from one side. The
    views take them in turn."""
    half: HalfName = "all"
    """Half of the meshes by name: settings are chosen on one, figures come from the other."""

    def check(self) -> None:
        """Raise InputError if a value is out of its range."""
        if self.poses < 1:
            raise InputError(f"--poses must be >= 1, got {self.poses}")
        if self.neighbours and FACE_ON in self.views:
            raise InputError(f"--views must be elevations with --neighbours, got {FACE_ON!r}")
        if self.hidden and self.neighbours:
            raise InputError(f"--hidden needs objects without --neighbours, got {self.hidden}")
        if any(not 0 <= share <= 95 for share in self.hidden):
            raise InputError(f"--hidden must be percentages within [0, 95], got {self.hidden}")
        if not self.views:
            raise InputError("--views must name an elevation in degrees or face, got none")
        self.directions()

    def directions(self) -> list[float | str]:
        """Return the elevations as numbers, degrees, and FACE_ON as it is."""
        found: list[float | str] = []
        for view in self.views:
            try:
                value = view if view == FACE_ON else float(view)
            except ValueError:
                value = None
            if value is None or (isinstance(value, float) and not 0 < value < 90):
                raise InputError(
                    f"--views must be elevations within (0, 90) degrees or {FACE_ON}, got {view!r}"
                )
            found.append(value)
        return found
