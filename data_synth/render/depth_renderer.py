"""Choose a renderer, and render tabletop scenes."""

from __future__ import annotations

import functools
import logging
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import DeviceError, InputError

from ..mujoco_import import import_mujoco
from ..scenes.fixture import BACKGROUND_NUMBER, BackgroundKind
from ..scenes.furnished_scene import FurnishedScene, fixture_name, furnished_spec
from ..scenes.tabletop_scene import TabletopScene
from ..scenes.tabletop_spec import FLOOR, TABLE_TOP, tabletop_spec
from .gl_probe import gl_fault, gl_module
from .gl_renderer import GlRenderer
from .ray_renderer import RayRenderer
from .rendered_view import DepthRenderer, RenderedView

Backend = Literal["auto", "gl", "rays"]
"""``gl`` uses OpenGL, ``rays`` casts rays on the CPU, ``auto`` uses OpenGL if available."""

DEFAULT_MAX_RANGE_M = 4.0
"""Maximum depth that a tabletop depth camera reads."""

_GL_ADVICE = "on Debian or Ubuntu install libegl1 and libgl1-mesa-dri"

_log = logging.getLogger("eyehand")


@functools.cache
def open_renderer(backend: Backend = "auto") -> DepthRenderer:
    """Open a renderer, or return the one that this process already has.

    The choice of ``auto`` is logged once, to the logger ``eyehand``. ``auto`` does not use OpenGL
    if the environment variable `MUJOCO_GL` is ``off``.

    Parameters
    ----------
    backend
        Name of the back end.

    Raises
    ------
    InputError
        If there is no such back end.
    DeviceError
        If ``gl`` was requested and cannot be used, or MuJoCo cannot be loaded.
    """
    if backend not in get_args(Backend):
        raise InputError(f"renderer must be one of {', '.join(get_args(Backend))}, got {backend!r}")
    if backend == "rays":
        return RayRenderer()
    if backend == "gl":
        return GlRenderer()
    fault = gl_fault()
    if not fault:
        try:
            renderer = open_renderer("gl")
        except DeviceError as error:
            fault = str(error)
        else:
            _log.info("depth images are rendered with OpenGL")
            return renderer
    _log.warning(
        "depth images are rendered by slower ray casting, because OpenGL is not available (%s)%s",
        fault,
        "" if gl_module() is None or "pip install" in fault else f"; {_GL_ADVICE}",
    )
    return open_renderer("rays")


def render_scene(
    scene: TabletopScene | FurnishedScene,
    *,
    renderer: DepthRenderer | None = None,
    colour: bool = True,
    max_range: float = DEFAULT_MAX_RANGE_M,
) -> RenderedView:
    """Render the view of the scene's camera, without noise.

    Parameters
    ----------
    scene
        The scene.
    renderer
        Renderer; `open_renderer` chooses one if not given.
    colour
        Whether to render colours too. They take most of the time.
    max_range
        Maximum depth with a reading, m.

    Returns
    -------
    RenderedView
        Depth, labels, background kinds and colour. Label 0 is background; label k is
        ``scene.objects[k - 1]``.

    Raises
    ------
    InputError
        If `max_range` is not positive.
    DeviceError
        If no renderer works on this machine.
    """
    if not 0 < max_range < np.inf:
        raise InputError(f"max_range must be > 0 m and finite, got {max_range}")
    mujoco = import_mujoco()
    renderer = renderer or open_renderer()
    model, labels = _labelled_model(scene)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    view = renderer.render(
        model,
        data,
        scene.intrinsics,
        scene.T_world_camera,
        labels,
        max_range=max_range,
        colour=colour,
    )
    objects = np.maximum(view.labels, 0)
    background = np.maximum(-view.labels, 0).astype(np.uint8)
    return RenderedView(view.depth, objects, view.colour, background)


def _labelled_model(scene: TabletopScene | FurnishedScene) -> tuple[Any, NDArray[np.int32]]:
    """Return the scene's `MjModel` and the label of each geom.

    Labels are numbers of objects, or numbers of background kinds times -1.
    """
    kinds: dict[str, BackgroundKind]
    if isinstance(scene, FurnishedScene):
        model = furnished_spec(scene.objects, scene.fixtures, free=False).compile()
        kinds = {fixture_name(k): item.kind for k, item in enumerate(scene.fixtures)}
    else:
        model = tabletop_spec(scene.objects, scene.table, free=False).compile()
        kinds = {TABLE_TOP: "table", FLOOR: "floor"}
    labels = np.zeros(model.ngeom, dtype=np.int32)
    for k, item in enumerate(scene.objects):
        labels[model.geom(item.name).id] = k + 1
    for name, kind in kinds.items():
        labels[model.geom(name).id] = -BACKGROUND_NUMBER[kind]
    return model, labels
