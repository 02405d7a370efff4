"""Exported bodies compile in MuJoCo with the mass and the pose of the solid."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.robot_files import primitive, robot_files
from eyehand.apps.fitting.solid_files import solid_files
from eyehand.apps.mesh_file import mesh_bytes
from eyehand.data_synth import import_mujoco
from eyehand.errors import DeviceError
from eyehand.perception import Superquadric
from eyehand.perception.superquadric import mesh

mujoco = import_mujoco()

POSE = RigidTransform.from_components(
    [0.3, -0.1, 0.8], Rotation.from_euler("xyz", [100.0, 40.0, -70.0], degrees=True)
)
SOLIDS = {
    "sphere": Superquadric(np.full(3, 0.03), (1.0, 1.0), POSE, "sphere"),
    "ellipsoid": Superquadric(np.array([0.05, 0.04, 0.03]), (1.0, 1.0), POSE, "ellipsoid"),
    "cylinder": Superquadric(np.array([0.03, 0.03, 0.07]), (0.1, 1.0), POSE, "cylinder"),
    "box": Superquadric(np.array([0.05, 0.04, 0.03]), (0.1, 0.1), POSE, "box"),
    "superquadric": Superquadric(np.array([0.05, 0.04, 0.03]), (0.4, 0.7), POSE),
    "tapered": Superquadric(np.array([0.04, 0.04, 0.05]), (0.1, 1.0), POSE, "tapered", (0.3, 0.3)),
}
SHAPES = {
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "superquadric": mujoco.mjtGeom.mjGEOM_MESH,
    "tapered": mujoco.mjtGeom.mjGEOM_MESH,
}


def stl(solid: Superquadric) -> bytes:
    own = Superquadric(
        solid.semi_axes, solid.exponents, RigidTransform.identity(), solid.kind, solid.taper
    )
    return mesh_bytes(*mesh(own, 64), "stl")


def models(solid: Superquadric, density: float = 1000.0):
    """Compile the MJCF and the URDF of a solid."""
    meshes = {"a b_body.stl": stl(solid)}
    made = robot_files("a b", [solid], {0: "a b_body.stl"}, meshes, density=density)
    return [mujoco.MjModel.from_xml_string(text, meshes) for text in (made.mjcf, made.urdf)]


def inertia_in_world(model) -> np.ndarray:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = model.jnt_bodyid[0]
    turn = data.ximat[body].reshape(3, 3)
    return turn @ np.diag(model.body_inertia[body]) @ turn.T


@pytest.mark.parametrize("kind", SOLIDS)
def test_each_kind_has_its_geom_in_both_formats(kind):
    mjcf, urdf = models(SOLIDS[kind])
    assert mjcf.ngeom == urdf.ngeom == 1
    assert mjcf.geom_type[0] == SHAPES[kind]
    urdf_shape = "superquadric" if kind == "ellipsoid" else kind
    assert urdf.geom_type[0] == SHAPES[urdf_shape]


@pytest.mark.parametrize("kind", SOLIDS)
def test_body_is_free_with_mass_and_pose_of_the_solid(kind):
    solid = SOLIDS[kind]
    sharp = {"cylinder": np.pi * 0.03**2 * 0.14, "box": 8 * np.prod(solid.semi_axes)}
    for model in models(solid, density=500.0):
        body = model.jnt_bodyid[0]
        assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
        mass = 500.0 * sharp.get(kind, solid.volume)
        assert model.body_mass[body] == pytest.approx(mass, rel=0.01)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert data.xpos[body] == pytest.approx(solid.centre, abs=1e-6)
        assert data.xmat[body].reshape(3, 3) == pytest.approx(solid.rotation, abs=1e-5)


@pytest.mark.parametrize("kind", SOLIDS)
def test_both_formats_have_the_same_mass_and_inertia(kind):
    mjcf, urdf = models(SOLIDS[kind])
    assert urdf.body_mass[1] == pytest.approx(mjcf.body_mass[1], rel=1e-5)
    assert inertia_in_world(urdf) == pytest.approx(inertia_in_world(mjcf), rel=1e-4, abs=1e-9)


def test_cylinder_has_the_pose_of_its_superquadric():
    solid = SOLIDS["cylinder"]
    (mjcf, _) = models(solid)
    data = mujoco.MjData(mjcf)
    mujoco.mj_forward(mjcf, data)
    top = solid.to_parent([0.0, 0.0, 0.07])
    end = data.geom_xpos[0] + data.geom_xmat[0].reshape(3, 3) @ [0, 0, mjcf.geom_size[0][1]]
    assert end == pytest.approx(top, abs=1e-6)


def test_nearly_round_solids_are_not_primitives():
    near = Superquadric(np.full(3, 0.03), (1.01, 1.0), POSE)
    oval = Superquadric(np.array([0.031, 0.03, 0.05]), (0.1, 1.0), POSE)
    soft = Superquadric(np.full(3, 0.03), (0.2, 0.2), POSE)
    assert [primitive(solid) for solid in (near, oval, soft)] == [None, None, None]
    assert primitive(SOLIDS["tapered"]) is None


def test_several_parts_are_one_body():
    handle = Superquadric(
        np.array([0.01, 0.01, 0.03]), (1.0, 1.0), RigidTransform.from_translation([0.4, 0, 1.0])
    )
    parts = [SOLIDS["cylinder"], SOLIDS["box"], handle]
    made = robot_files("mug", parts, {2: "m.stl"}, {"m.stl": stl(handle)})
    for text in (made.mjcf, made.urdf):
        model = mujoco.MjModel.from_xml_string(text, {"m.stl": stl(handle)})
        assert model.njnt == 1
        assert model.ngeom == 3
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        ends = np.sort(data.geom_xpos, axis=0)
        assert ends == pytest.approx(np.sort([p.centre for p in parts], axis=0), abs=1e-6)


def test_object_with_parts_is_written_as_one_body(hammer):
    files = solid_files(hammer, form="stl", density=1000.0)
    assert not any(name.startswith("hammer_body") and name.endswith(".stl") for name in files)
    model = mujoco.MjModel.from_xml_string(files["hammer_body.xml"].decode())
    assert list(model.geom_type) == [SHAPES["box"], SHAPES["cylinder"]]
    assert len(json.loads(files["hammer_solid.json"])["parts"]) == 2


def test_urdf_has_visual_and_collision(can):
    urdf = solid_files(can, form="ply", density=1000.0)["can_body.urdf"].decode()
    assert urdf.count("<visual") == urdf.count("<collision") == 1
    assert urdf.count("<cylinder") == 2


def test_mujoco_error_is_one_line():
    with pytest.raises(DeviceError, match="MuJoCo rejects") as caught:
        robot_files("a", [SOLIDS["superquadric"]], {0: "a.stl"}, {"a.stl": b"no mesh"})
    assert "\n" not in str(caught.value)


def test_files_written_to_a_folder_load_from_there(lens, tmp_path):
    for name, content in solid_files(lens, form="obj", density=1000.0).items():
        (tmp_path / name).write_bytes(content)
    assert {path.name for path in tmp_path.iterdir()} == {
        "lens_solid.json",
        "lens_solid.png",
        "lens_solid.obj",
        "lens_body.xml",
        "lens_body.urdf",
        "lens_body.stl",
    }
    for suffix in (".xml", ".urdf"):
        model = mujoco.MjModel.from_xml_path(str(tmp_path / f"lens_body{suffix}"))
        assert model.ngeom == 1
