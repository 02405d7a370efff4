"""The posture with minimum spring energy under tendon excursions."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from eyehand.data_synth.cell.tendon_geometry import tendon_posture

MOMENTS = np.array([[0.012, 0.0045, 0.0014], [0.0, 0.008, 0.005]])
STIFFNESS = np.array([0.05, 0.04, 0.03])
REST = np.array([-0.6, 0.0, 0.0])
LIMITS = np.array([[-0.6, 1.5], [0.0, 1.6], [0.0, 1.3]])


def test_one_tendon_bends_joints_in_proportion_to_moment_arm_over_stiffness():
    pulled = np.array([0.004, 0.0])
    q = tendon_posture(MOMENTS[:1], pulled[:1], STIFFNESS, REST, LIMITS)
    tension = (q[0] - REST[0]) * STIFFNESS[0] / MOMENTS[0, 0]
    assert np.allclose(STIFFNESS * (q - REST), tension * MOMENTS[0], atol=1e-9)
    assert np.isclose(MOMENTS[0] @ (q - REST), pulled[0])


@given(st.floats(0.0, 0.06), st.floats(0.0, 0.04))
def test_posture_satisfies_excursions_and_joint_limits(first: float, second: float):
    pulled = np.array([first, second])
    q = tendon_posture(MOMENTS, pulled, STIFFNESS, REST, LIMITS)
    max_excursions = MOMENTS @ (LIMITS[:, 1] - REST)
    assert (q >= LIMITS[:, 0] - 1e-12).all()
    assert (q <= LIMITS[:, 1] + 1e-12).all()
    assert (MOMENTS @ (q - REST) >= np.minimum(pulled, max_excursions) - 1e-6).all()


def test_posture_without_excursion_is_spring_rest():
    assert np.allclose(tendon_posture(MOMENTS, np.zeros(2), STIFFNESS, REST, LIMITS), REST)
