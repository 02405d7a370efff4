"""Physics of rigid objects on a table: contact with the table, and a bowl that gathers them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .rigid_physics import RigidPhysics
from .tabletop_scene import Table, TabletopObject
from .tabletop_spec import tabletop_spec

BOWL_DRAG_HZ = 10.0
"""Share of its horizontal speed that an object in a bowl loses per second, against swinging."""


class TabletopPhysics(RigidPhysics):
    """Objects on an infinite table."""

    def __init__(
        self, objects: Sequence[TabletopObject], table: Table, *, no_creep: bool = False
    ) -> None:
        """Create the bodies of the objects.

        Parameters
        ----------
        objects, table
            The objects and the table.
        no_creep
            See :class:`RigidPhysics`.
        """
        spec = tabletop_spec(objects, table, free=True)
        reach = [np.linalg.norm(item.shape.semi_axes) for item in objects]
        super().__init__(spec, [item.name for item in objects], reach, no_creep=no_creep)
        self._table = self._model.geom("table").id
        self._mass = np.array([[item.mass] for item in objects])
        self._pull, self._bowl_radius = 0.0, 1.0

    def max_penetration(self) -> float:
        """Return the largest depth of an object inside another or the table, m; 0 if none."""
        geoms = [*self._geom, self._table]
        gaps = (
            self._distance(geoms[one], geoms[other])
            for one in range(self._count)
            for other in range(one + 1, self._count + 1)
        )
        return max(0.0, -min(gaps))

    def bowl(self, radius: float, pull: float) -> None:
        """Pull objects to the middle of the table, as a bowl would; a pull of 0 makes it flat.

        Parameters
        ----------
        radius
            Distance from the z-axis within which the pull decreases to 0, m.
        pull
            Horizontal acceleration outside it, m/s²; divided by g, the slope of the wall.
        """
        self._bowl_radius, self._pull = radius, pull
        self._data.xfrc_applied[:] = 0.0

    def on_table(self) -> set[int]:
        """Return the indices of the objects that touch the table."""
        pairs = self._data.contact.geom
        touching = {int(g) for pair in pairs if self._table in pair for g in pair}
        return {k for k, geom in enumerate(self._geom) if geom in touching}

    def _step(self, count: int) -> None:
        if self._pull:
            level = self._data.qpos.reshape(self._count, 7)[:, :2]
            speed = self._data.qvel.reshape(self._count, 6)[:, :2]
            away = np.maximum(np.linalg.norm(level, axis=1, keepdims=True), self._bowl_radius)
            wanted = -self._pull * level / away - BOWL_DRAG_HZ * speed
            self._data.xfrc_applied[1:, :2] = self._mass * wanted
        super()._step(count)
