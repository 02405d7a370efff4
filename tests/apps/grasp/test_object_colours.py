"""An object keeps its colour from look to look, and shares it with no other of the look."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from eyehand.apps.grasp.object_colours import MAX_DISPLACEMENT, colour_numbers
from eyehand.apps.grasp.perceived_picture import perceived_picture
from eyehand.apps.scene_picture import PALETTE, colour_of
from eyehand.perception import SceneObject
from eyehand.perception.superquadric import SuperquadricFit


def seen(*places: tuple[float, float]) -> list[SceneObject]:
    """Objects at places on the table, labelled in order."""
    unfit = SuperquadricFit.rejected("too few points")
    return [
        SceneObject(label, np.array([[x, y, 0.02]]), 9, unfit, 1.0, 0)
        for label, (x, y) in enumerate(places, start=1)
    ]


@given(
    order=st.permutations(range(9)),
    seed=st.integers(0, 2**32 - 1),
    gone=st.sets(st.integers(0, 8), max_size=8),
)
def test_moved_and_relabelled_objects_keep_their_numbers(order, seed, gone):
    grid = [(0.1 * (k % 3), 0.1 * (k // 3)) for k in range(9)]
    moves = np.random.default_rng(seed).uniform(-0.02, 0.02, (9, 2))
    left = [k for k in order if k not in gone]
    later = seen(*(tuple(np.add(grid[k], moves[k])) for k in left))
    first, second = colour_numbers([seen(*grid), later], {})
    assert first == {k: k for k in range(1, 10)}
    assert list(second.values()) == [k + 1 for k in left]


@given(
    st.lists(
        st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), max_size=14), max_size=5
    ),
    st.dictionaries(st.integers(0, 4), st.integers(1, 14)),
)
def test_no_two_objects_of_a_look_share_a_number(places, taken):
    captures = [seen(*one) for one in places]
    numbered = colour_numbers(captures, taken)
    for items, numbers in zip(captures, numbered, strict=True):
        assert set(numbers) == {item.label for item in items}
        assert len(set(numbers.values())) == len(items)
    # What comes later changes nothing before it.
    assert colour_numbers(captures[:-1], taken) == numbered[:-1]


def test_what_comes_to_light_under_a_taken_object_has_a_new_colour():
    captures = [seen((0.0, 0.0), (0.2, 0.0)), seen((0.01, 0.0), (0.2, 0.0))]
    assert colour_numbers(captures, {}) == ({1: 1, 2: 2}, {1: 1, 2: 2})
    assert colour_numbers(captures, {0: 1}) == ({1: 1, 2: 2}, {1: 3, 2: 2})


def test_an_object_unseen_for_a_look_has_its_colour_again():
    captures = [seen((0.0, 0.0), (0.2, 0.0)), seen((0.2, 0.0)), seen((0.2, 0.0), (0.0, 0.0))]
    assert colour_numbers(captures, {})[2] == {1: 2, 2: 1}


def test_an_object_far_from_all_before_is_a_new_one_and_old_colours_come_back_last():
    far = 3 * MAX_DISPLACEMENT
    captures = [seen((k * far, 0.0)) for k in range(len(PALETTE) + 2)]
    numbers = [one[1] for one in colour_numbers(captures, {})]
    assert numbers == [*range(1, len(PALETTE) + 1), 1, 2]


def test_every_number_has_a_colour_of_its_own():
    colours = np.array([colour_of(number) for number in range(1, 31)], dtype=float)
    apart = np.linalg.norm(colours[:, None] - colours, axis=2) + 1e3 * np.eye(len(colours))
    assert apart.min() > 15


def test_a_look_s_picture_has_the_colours_that_are_asked_for(cleared):
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
