"""The drawing of a grasp in a picture."""

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.grasp.grasp_glyph import draw_grasp, preferred_palm
from eyehand.grasping.plan import ApproachTask, GraspPlan, Score
from eyehand.perception import CameraIntrinsics, DepthFrame

TIP, DOWN, CLOSING = np.array([0.02, 0.01, 0.03]), np.array([0.0, 0.0, -1.0]), np.eye(3)[0]


def test_jaws_of_a_grasp_end_at_their_fingertips():
    task = ApproachTask("position", 3, TIP, DOWN, 0.0, "tool centre point")
    plan = GraspPlan(
        "pincer", "top", 0.06, CLOSING, DOWN, (task,), Score(0.9, {}), {}, (0.1, 0.2, 0.3), ""
    )
    camera = CameraIntrinsics(500.0, 500.0, 319.5, 239.5, 640, 480)
    eye = RigidTransform.from_components(
        [0.0, -0.5, 0.3], Rotation.from_euler("x", -120.0, degrees=True)
    )
    frame = DepthFrame(np.ones((480, 640), np.float32), camera, eye)
    picture = np.full((480, 640, 3), 128, np.uint8)
    draw_grasp(picture, frame, plan)
    tool = preferred_palm(plan)
    np.testing.assert_allclose(tool.translation, TIP)
    np.testing.assert_allclose(tool.rotation.as_matrix()[:, 2], DOWN)
    for side in (-0.03, 0.03):
        u, v = camera.project(eye.inv().apply(TIP + side * CLOSING))
        assert (picture[round(v) - 3 : round(v) + 1, round(u)] == 255).all(axis=1).any()
        assert (picture[round(v) + 9, round(u)] == 128).all()
