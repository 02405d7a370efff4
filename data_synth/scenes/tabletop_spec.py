"""A tabletop as a MuJoCo model description, for physics and for rendering."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from eyehand.perception.superquadric import Superquadric

from ..mujoco_import import import_mujoco
from .convex_mesh import convex_mesh
from .tabletop_scene import Table, TabletopObject
from .wood_texture import wood_colour

VISIBLE_GROUPS = (1, 1, 1, 0, 0, 0)
PHYSICS_GROUP = 3
"""Geom groups. MuJoCo draws groups 0 to 2, so group 3 collides but is invisible."""
TABLE_TOP = "table_top"
"""Visible geom of the table."""
FLOOR = "floor"
"""Geom of the floor."""
OBJECT_MATERIAL = "object"
"""Material of all but the table top."""

SLIDING_FRICTION = 0.6
TORSIONAL_FRICTION_M = 0.005
ROLLING_FRICTION_M = 0.002
"""Coulomb coefficients of object on object and on table; the last stops a ball within cm."""

_TIMESTEP_S = 0.003
_SOLREF = (0.006, 1.0)
_SOLIMP = (0.99, 0.999, 1e-4, 0.5, 2.0)
"""Stiff enough that objects sink less than 0.02 mm into the table."""
_IMPRATIO = 10.0
"""Stiffness of friction over that of normal contact: objects do not creep."""

_TABLE_THICKNESS_M = 0.03
FLOOR_EXTENT_M = 30.0
FLOOR_FACET_M = 0.4
"""OpenGL lights the corners of facets: finer facets show a rounder spot of light."""
_FLOOR_COLOUR = (0.62, 0.63, 0.65)
_TEXTURE_PX_PER_M = 1000
_SLICES = 160
"""Facets of round primitives in OpenGL: a 120 mm ball is exact to 0.02 mm."""
_KEY_LIGHT = (-0.4, 0.55, 1.85)
"""Position of the shadow-casting light relative to the table's centre, m."""


def tabletop_spec(
    objects: Sequence[TabletopObject], table: Table, *, free: bool, visuals: bool | None = None
) -> Any:
    """Describe a table, its floor, lights, and one body per object.

    Body and geom of an object have its name. Objects rest on the geom `table`.

    Parameters
    ----------
    objects
        Objects on the table, each at the pose of its shape.
    table
        The table.
    free
        Give the objects a free joint (for physics) or fix them (for rendering).
    visuals
        Add visual parts: table top, floor, lamp, materials. None adds them if objects are fixed.

    Returns
    -------
    mujoco.MjSpec
        To be extended (by a robot, say) or compiled.
    """
    mujoco = import_mujoco()
    spec = new_spec()
    visuals = not free if visuals is None else visuals
    _add_table(mujoco, spec, table, visuals=visuals)
    if visuals:
        _add_wood(mujoco, spec, table)
        add_lighting(spec, table.height)
    for item in objects:
        add_solid(spec, item, free=free, visuals=visuals)
    return spec


def new_spec() -> Any:
    """Return an empty `MjSpec` with the physics options of all scenes."""
    mujoco = import_mujoco()
    spec = mujoco.MjSpec()
    spec.option.timestep = _TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = _IMPRATIO
    return spec


def add_solid(spec: Any, item: TabletopObject, *, free: bool, visuals: bool) -> None:
    """Add a solid as a body and a geom of its name; `free` gives it a free joint."""
    mujoco = import_mujoco()
    body = spec.worldbody.add_body(name=item.name)
    body.pos = item.shape.centre
    body.quat = item.shape.pose.rotation.as_quat(scalar_first=True)
    if free:
        body.add_freejoint()
    geom = body.add_geom(name=item.name, mass=item.mass)
    geom.rgba = [*item.colour, 1.0]
    _set_solid(mujoco, spec, geom, item.name, item.shape)
    set_contact(geom)
    if visuals:
        geom.material = OBJECT_MATERIAL


def _set_solid(mujoco: Any, spec: Any, geom: Any, name: str, shape: Superquadric) -> None:
    a1, a2, a3 = shape.semi_axes
    types = mujoco.mjtGeom
    if shape.kind == "sphere":
        geom.type, geom.size = types.mjGEOM_SPHERE, [a1, 0, 0]
    elif shape.kind == "cylinder":
        geom.type, geom.size = types.mjGEOM_CYLINDER, [a1, a3, 0]
    elif shape.kind == "ellipsoid":
        geom.type, geom.size = types.mjGEOM_ELLIPSOID, [a1, a2, a3]
    elif shape.kind == "box":
        geom.type, geom.size = types.mjGEOM_BOX, [a1, a2, a3]
    else:
        vertices, faces = convex_mesh(shape)
        spec.add_mesh(name=name, uservert=vertices.ravel(), userface=faces.ravel())
        geom.type, geom.meshname = types.mjGEOM_MESH, name


def set_contact(geom: Any) -> None:
    """Set friction and stiffness of an object's geom in an `MjSpec`."""
    geom.condim = 6
    geom.friction = [SLIDING_FRICTION, TORSIONAL_FRICTION_M, ROLLING_FRICTION_M]
    geom.solref, geom.solimp = _SOLREF, _SOLIMP


def _add_table(mujoco: Any, spec: Any, table: Table, *, visuals: bool) -> None:
    world = spec.worldbody
    # An infinite plane carries objects more cheaply and evenly than the top of a box.
    plane = world.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, group=PHYSICS_GROUP)
    plane.size, plane.pos = [0, 0, 1], [0, 0, table.height]
    set_contact(plane)
    if not visuals:
        return
    half = _TABLE_THICKNESS_M / 2
    top = world.add_geom(name=TABLE_TOP, type=mujoco.mjtGeom.mjGEOM_BOX, contype=0, conaffinity=0)
    top.size = [table.size[0] / 2, table.size[1] / 2, half]
    top.pos, top.material = [0, 0, table.height - half], "wood"
    floor = world.add_geom(name=FLOOR, type=mujoco.mjtGeom.mjGEOM_PLANE, contype=0, conaffinity=0)
    floor.size = [FLOOR_EXTENT_M / 2, FLOOR_EXTENT_M / 2, FLOOR_FACET_M]
    floor.pos, floor.rgba = [0, 0, table.height - table.floor_drop], [*_FLOOR_COLOUR, 1]
    floor.material = OBJECT_MATERIAL


def _add_wood(mujoco: Any, spec: Any, table: Table) -> None:
    texture = spec.add_texture(name="wood", type=mujoco.mjtTexture.mjTEXTURE_2D)
    texture.nchannel = 3
    texture.width, texture.height, texture.data = _wood_texture(table.size)
    wood = spec.add_material(name="wood", specular=0.15, shininess=0.3)
    wood.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "wood"


def add_lighting(spec: Any, height: float) -> None:
    """Add lamps and the material of objects; `height` is the world z of the work surface, m."""
    spec.add_material(name=OBJECT_MATERIAL, specular=0.35, shininess=0.6)
    visual = spec.visual
    visual.headlight.ambient, visual.headlight.diffuse = [0.38] * 3, [0.22] * 3
    visual.headlight.specular = [0.05] * 3
    # A steep lamp, a narrow cone and a fine map avoid speckled shadows on the floor.
    visual.map.shadowscale = 0.4
    visual.quality.shadowsize, visual.quality.offsamples = 4096, 4
    visual.quality.numslices, visual.quality.numstacks = _SLICES, _SLICES // 2
    lamp = spec.worldbody.add_light(name="lamp", castshadow=True, cutoff=70.0, exponent=1.0)
    lamp.pos = np.add(_KEY_LIGHT, [0, 0, height])
    lamp.dir = np.negative(_KEY_LIGHT)
    lamp.ambient, lamp.diffuse, lamp.specular = [0.0] * 3, [0.58, 0.56, 0.52], [0.4] * 3


@functools.lru_cache(maxsize=4)
def _wood_texture(size: tuple[float, float]) -> tuple[int, int, bytes]:
    columns, rows = (max(int(extent * _TEXTURE_PX_PER_M), 1) for extent in size)
    x = ((np.arange(columns) + 0.5) / columns - 0.5) * size[0]
    y = ((np.arange(rows) + 0.5) / rows - 0.5) * size[1]
    image = (wood_colour(*np.meshgrid(x, y)) * 255).astype(np.uint8)
    return columns, rows, image.tobytes()
