"""Views of objects that something nearer hides from one side."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.fitting.bench.mesh_views import NEARER, hide_in_turn, hide_side, mesh_views

from .test_mesh_views import box, household


@pytest.fixture(scope="module")
def view():
    return mesh_views([household([box()])], (40.0,), noise="none")[0]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("share", [0.3, 0.7, 0.9])
def test_share_of_rows_or_columns_is_hidden_from_one_side(view, share, seed):
    whole = view.object_pixels == 1
    hidden = hide_side(replace(view, seed=seed), share)
    rest = hidden.object_pixels == 1
    assert rest.any()
    assert not np.any(rest & ~whole)
    axis = 1 - seed % 2
    lines, left = np.flatnonzero(whole.any(axis=axis)), np.flatnonzero(rest.any(axis=axis))
    assert len(left) / len(lines) == pytest.approx(1 - share, abs=0.1)
    assert (left[0] == lines[0]) != (left[-1] == lines[-1])
    changed = hidden.frame.depth != view.frame.depth
    assert np.array_equal(whole & ~rest, whole & changed)
    assert (view.frame.depth - hidden.frame.depth)[changed] == pytest.approx(NEARER, abs=1e-6)


def test_shares_come_in_turn_and_none_changes_nothing(view):
    first, second, third = hide_in_turn([view, view, view], [0.0, 0.5])
    assert first is view
    assert third is view
    assert second.name.endswith("50 % hidden")
