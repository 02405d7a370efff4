"""Tests of points in text files."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from eyehand.errors import InputError
from eyehand.perception.io.point_cloud import parse_text_points, points_text

EXPECTED = [[0.1, -2, 3e-3], [4, 5, 6]]


@pytest.mark.parametrize(
    "text",
    [
        "0.1 -2 3e-3\n4 5 6\n",
        "0.1,-2,3e-3\n4,5,6",
        "0.1;-2;3e-3\r\n4;5;6\r\n",
        "0.1\t-2\t3e-3\t255\t0\t0\n4\t5\t6\t1\t2\t3\n",
        "# made by hand\n0.1 -2 3e-3\n\n// the end\n4 5 6\n",
        "x,y,z\n0.1,-2,3e-3\n4,5,6\n",
        '"Y" "X" "Z" i\n-2 0.1 3e-3 9\n5 4 6 9\n',
        "\ufeffid, x, y, z\n1, 0.1, -2, 3e-3\n2, 4, 5, 6\n",
    ],
)
def test_separators_headers_and_comments_are_parsed(text: str) -> None:
    np.testing.assert_array_equal(parse_text_points(text.encode()), EXPECTED)


@given(
    hnp.arrays(
        np.float64,
        st.tuples(st.integers(1, 9), st.just(3)),
        elements=st.floats(allow_nan=False, allow_infinity=False),
    )
)
def test_written_points_are_read_back_exactly(points: np.ndarray) -> None:
    np.testing.assert_array_equal(parse_text_points(points_text(points, None).encode()), points)


def test_colours_follow_coordinates() -> None:
    text = points_text(np.array([[1.0, 2.0, 0.1]]), np.array([[255, 0, 7]], dtype=np.uint8))
    assert text == "1.0 2.0 0.1 255 0 7\n"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"# nothing\n\n", "holds no points, expected x y z a line"),
        (b"x y z\n", "holds a header and no points"),
        (b"a b c\n1 2 3\n", "first line is 'a b c', expected numbers or the names x, y, z"),
        (b"x x y z\n1 2 3 4\n", "first line is 'x x y z'"),
        (b"1 2\n3 4\n", "not a table of numbers"),
        (b"1 2 3\n4 five 6\n", "not a table of numbers .*five"),
        (b"1,5;2,5;3,5\n", "holds decimal commas .*, expected decimal points"),
        (b"\xff\xfe\x00\x01", r"not a text file \(byte 0\)"),
        (b",,\n,\n", r"first line is .*, expected numbers"),
    ],
)
def test_invalid_text_is_rejected(data: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_text_points(data)
