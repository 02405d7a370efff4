"""Objects keep their colour number over captures, and numbers are unique in a capture."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from eyehand.apps.grasp.object_colours import MAX_DISPLACEMENT, colour_numbers
from eyehand.apps.grasp.perceived_picture import perceived_picture
from eyehand.apps.scene_picture import PALETTE, colour_of
from eyehand.perception import SceneObject
from eyehand.perception.superquadric import SuperquadricFit


def objects(*places: tuple[float, float]) -> list[SceneObject]:
    """Return objects at positions on the table, labelled in order."""
    no_fit = SuperquadricFit.rejected("too few points")
    return [
        SceneObject(label, np.array([[x, y, 0.02]]), 9, no_fit, 1.0, 0)
        for label, (x, y) in enumerate(places, start=1)
    ]


@given(
    order=st.permutations(range(9)),
    seed=st.integers(0, 2**32 - 1),
    removed=st.sets(st.integers(0, 8), max_size=8),
)
def test_moved_and_relabelled_objects_keep_their_numbers(order, seed, removed):
    grid = [(0.1 * (k % 3), 0.1 * (k // 3)) for k in range(9)]
    moves = np.random.default_rng(seed).uniform(-0.02, 0.02, (9, 2))
    left = [k for k in order if k not in removed]
    later = objects(*(tuple(np.add(grid[k], moves[k])) for k in left))
    first, second = colour_numbers([objects(*grid), later], {})
    assert first == {k: k for k in range(1, 10)}
    assert list(second.values()) == [k + 1 for k in left]


@given(
    st.lists(
        st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), max_size=14), max_size=5
    ),
    st.dictionaries(st.integers(0, 4), st.integers(1, 14)),
)
def test_numbers_of_capture_are_unique_and_final(places, removed):
    captures = [objects(*one) for one in places]
    numbered = colour_numbers(captures, removed)
    for items, numbers in zip(captures, numbered, strict=True):
        assert set(numbers) == {item.label for item in items}
        assert len(set(numbers.values())) == len(items)
    # Later captures do not change earlier numbers.
    assert colour_numbers(captures[:-1], removed) == numbered[:-1]


def test_object_at_place_of_removed_one_gets_new_colour():
    captures = [objects((0.0, 0.0), (0.2, 0.0)), objects((0.01, 0.0), (0.2, 0.0))]
    assert colour_numbers(captures, {}) == ({1: 1, 2: 2}, {1: 1, 2: 2})
    assert colour_numbers(captures, {0: 1}) == ({1: 1, 2: 2}, {1: 3, 2: 2})


def test_object_missing_in_one_capture_keeps_colour():
    captures = [
        objects((0.0, 0.0), (0.2, 0.0)),
        objects((0.2, 0.0)),
        objects((0.2, 0.0), (0.0, 0.0)),
    ]
    assert colour_numbers(captures, {})[2] == {1: 2, 2: 1}


def test_distant_object_is_new_and_old_colours_are_reused_last():
    far = 3 * MAX_DISPLACEMENT
    captures = [objects((k * far, 0.0)) for k in range(len(PALETTE) + 2)]
    numbers = [one[1] for one in colour_numbers(captures, {})]
    assert numbers == [*range(1, len(PALETTE) + 1), 1, 2]


def test_colours_of_numbers_differ():
    colours = np.array([colour_of(number) for number in range(1, 31)], dtype=float)
    apart = np.linalg.norm(colours[:, None] - colours, axis=2) + 1e3 * np.eye(len(colours))
    assert apart.min() > 15


def test_picture_uses_requested_colours(cleared):
    record, _ = cleared
    capture = record.captures[0]
    label = capture.target.label
    assert capture.colours[label] == label
    pictures = [
        perceived_picture(
            capture.frame, capture.scene, names=False, colours={label: number}
        ).astype(float)
        for number in (1, 3)
    ]
    changed = (pictures[0] != pictures[1]).any(axis=2)
    differ = (pictures[0] - pictures[1])[changed].mean(axis=0)
    assert changed.sum() > 100
    assert np.sign(differ).tolist() == np.sign(np.subtract(*PALETTE[[0, 2]].astype(int))).tolist()
