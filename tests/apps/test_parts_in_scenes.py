"""Objects of several parts in pictures, files and the visible share."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.perceived_frame import perceive_and_plan
from eyehand.apps.scene_json import fit_json
from eyehand.apps.scene_picture import covered, overlay_picture
from eyehand.data_synth.render import StagedObject, StagedScene, StagedView, staged_frame
from eyehand.data_synth.scenes.staged_solids import StagedSolid, Tube
from eyehand.perception import (
    FitOptions,
    PerceiveOptions,
    Superquadric,
    SuperquadricFit,
    fit_superquadric,
    perceive,
)
from eyehand.perception.visibility import visible_share

ELBOW = StagedSolid((Tube(((-0.06, 0.02), (0.06, 0.02), (0.06, 0.13)), 0.019),), 0.15)
VIEW = StagedView(image_size=(320, 240))


@pytest.fixture(scope="module")
def elbow():
    """Return the frame of a bent bar, its label image, and its fit in parts."""
    frame, labels = staged_frame(
        StagedScene((StagedObject(ELBOW, (0.0, 0.0, 0.0), yaw=0.6),), VIEW)
    )
    T_world_camera = frame.T_world_camera
    assert T_world_camera is not None
    cloud = T_world_camera.apply(frame.points()[labels == 1].astype(np.float64))
    fit = fit_superquadric(
        cloud,
        view_origin=T_world_camera.translation,
        support_plane=[0.0, 0.0, 1.0, 0.0],
        options=FitOptions(max_parts=3),
    )
    return frame, labels, fit


def test_bent_bar_is_fitted_and_written_as_two_parts(elbow):
    _, _, fit = elbow
    assert fit
    assert [part.kind for part in fit.parts] == ["cylinder", "cylinder"]
    radii = [part.semi_axes[0] for part in fit.parts]
    assert radii == pytest.approx([0.019, 0.019], abs=0.002)
    report = fit_json(fit)
    assert len(report["parts"]) == 2
    assert report["parts"][0] == report["solid"]


def test_visible_share_uses_the_outline_of_all_parts(elbow):
    frame, labels, fit = elbow
    pixels = int(np.count_nonzero(labels == 1))
    share = visible_share(pixels, fit, frame, frame.T_world_camera)
    assert 0.85 < share <= 1.0
    half = visible_share(pixels // 2, fit, frame, frame.T_world_camera)
    assert half == pytest.approx(share / 2, abs=0.1)
    one = SuperquadricFit(fit.parts[0], True, "", np.zeros(1), (), 0.0, parts=fit.parts[:1])
    twice = replace(one, parts=(fit.parts[0], fit.parts[0]))
    assert visible_share(100, twice, frame, frame.T_world_camera) == pytest.approx(
        visible_share(100, one, frame, frame.T_world_camera), rel=0.02
    )


def test_all_parts_are_drawn(elbow):
    frame, _, fit = elbow
    found = perceive_and_plan(frame)
    scene = found.scene
    item = replace(scene.objects[0], fit=fit, visible_share=1.0)
    one = replace(item, fit=replace(fit, parts=fit.parts[:1]))
    pictures = [
        overlay_picture(frame, replace(scene, objects=(which,)), found.plans)
        for which in (item, one)
    ]
    assert np.count_nonzero(np.any(pictures[0] != pictures[1], axis=2)) > 500


def test_lines_behind_a_part_are_covered():
    near = Superquadric(np.full(3, 0.03), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.5]))
    points = np.array([[0.0, 0.0, 0.7], [0.0, 0.0, 0.5], [0.0, 0.0, 0.4], [0.2, 0.0, 0.7]])
    hidden = covered(points, (near,), np.zeros(3))
    assert hidden.tolist() == [True, True, False, False]


def test_perceive_limits_the_number_of_parts(elbow):
    frame, _, _ = elbow
    scene = perceive(frame, PerceiveOptions(fit=FitOptions(max_parts=3)))
    assert all(len(item.fit.parts) <= 3 for item in scene.objects)
    assert any(item.fit for item in scene.objects)
