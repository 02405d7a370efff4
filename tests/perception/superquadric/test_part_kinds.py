"""Tests of the kinds of parts, and of the criterion by which parts are compared."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.perception import FitOptions, Superquadric
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.outliers import FilteredCloud
from eyehand.perception.superquadric.part_cloud import PartCloud, prepare_part_cloud
from eyehand.perception.superquadric.part_kinds import fit_kinds
from eyehand.perception.superquadric.parts import part_criterion
from eyehand.perception.superquadric.problem import Observation
from eyehand.perception.superquadric.starts import rotated_dual

OPTIONS = FitOptions(max_parts=2)


def box_cloud(count: int) -> tuple[Superquadric, PartCloud]:
    box = Superquadric(
        np.array([0.05, 0.03, 0.04]), (0.1, 0.1), RigidTransform.identity(), kind="box"
    )
    points = sample_surface(box, count, np.random.default_rng(0))
    cloud = FilteredCloud(points, pitch=0.002, on_grid=False)
    return box, prepare_part_cloud(Observation(cloud), OPTIONS)


def test_diamond_becomes_box():
    box, cloud = box_cloud(600)
    diamond = rotated_dual(cloud.scaled(replace(box, kind="superquadric")))
    assert diamond.exponents[1] > 1.5
    best = fit_kinds(diamond, np.ones(len(cloud.points), dtype=bool), cloud, OPTIONS)[0]
    assert best.kind == "box"
    sides = np.sort(np.exp(best.shape.log_axes)) * cloud.problem.unit
    assert sides == pytest.approx(np.sort(box.semi_axes), abs=1e-3)


@pytest.mark.parametrize(("count", "readings"), [(60, 30.0), (200, 100.0), (600, 150.0)])
def test_readings_of_criterion_depend_on_number_of_points(count, readings):
    _, cloud = box_cloud(count)
    value = part_criterion(2.0 * cloud.noise**2, 9, cloud)
    assert value == pytest.approx(2.0 * readings + 9 * np.log(readings))
