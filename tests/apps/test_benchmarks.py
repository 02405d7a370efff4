"""Timings of the stages on one synthetic frame: `make bench`."""

import pytest

from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame
from eyehand.grasping import load_hand, plan_grasps
from eyehand.perception import fit_superquadric, perceive, segment, warm_up


@pytest.fixture(scope="module")
def frame():
    """Five separate objects at 640x480 with realistic noise."""
    warm_up()
    scene = make_scene(5, TabletopOptions(count_range=(5, 5)))
    return render_frame(scene, DepthNoise.realistic(), 5, colour=False)[0]


def test_segment_640x480(benchmark, frame):
    assert benchmark(segment, frame).count == 5


def test_perceive_640x480_five_objects(benchmark, frame):
    assert len(benchmark(perceive, frame).objects) == 5


def test_plan_grasps_of_five_objects(benchmark, frame):
    scene = perceive(frame)
    assert benchmark(plan_grasps, scene, load_hand("panda"))


def test_fit_one_object_of_the_frame(benchmark, frame):
    scene = perceive(frame)
    support = scene.support
    assert support is not None
    fit = benchmark(
        fit_superquadric,
        scene.objects[0].points,
        view_origin=scene.view_origin,
        support_plane=[*support.normal, support.offset],
    )
    assert fit
