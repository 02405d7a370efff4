"""Tests of segmentation options: validation, and scaling with the image width."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame, SegmentationOptions
from eyehand.perception.segmentation.options import MIN_WINDOW
from eyehand.perception.segmentation.working_image import REFERENCE_WIDTH, working_image

DEFAULT = SegmentationOptions()
NUMBERS = [
    field.name
    for field in fields(SegmentationOptions)
    if field.name != "table_height" and not isinstance(field.default, bool)
]
INTEGERS = ["window", "stride", "threads", "min_object"]


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_numbers_must_be_finite_and_positive(name, value):
    with pytest.raises(InputError, match=name):
        SegmentationOptions(**{name: value})


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_table_height_must_be_finite(value):
    with pytest.raises(InputError, match="table_height"):
        SegmentationOptions(table_height=value)


@pytest.mark.parametrize("value", [-0.7, 0.0, 0.9, None])
def test_any_finite_table_height_is_accepted(value):
    assert SegmentationOptions(table_height=value).table_height == value


@pytest.mark.parametrize("name", ["stride", "threads", "min_object"])
@pytest.mark.parametrize("value", [1.5, 2.001])
def test_counts_must_be_integers(name, value):
    with pytest.raises(InputError, match=f"{name} must be a whole number and > 0, got {value}"):
        SegmentationOptions(**{name: value})


@pytest.mark.parametrize("window", [1, 2, 8])
def test_window_must_be_odd_and_at_least_three(window):
    with pytest.raises(InputError, match="window must be odd"):
        SegmentationOptions(window=window)


def test_reference_width_keeps_options():
    assert DEFAULT.scaled(REFERENCE_WIDTH) == DEFAULT


@given(width=st.integers(1, 5000), window=st.integers(1, 20).map(lambda k: 2 * k + 1))
def test_scaled_options_are_valid_integers(width, window):
    scaled = SegmentationOptions(window=window).scaled(width)
    assert scaled.window % 2 == 1
    assert scaled.window >= MIN_WINDOW
    assert all(isinstance(getattr(scaled, name), int) for name in INTEGERS)


def test_window_scales_with_width_and_area_with_its_square():
    options = SegmentationOptions(window=9, min_object=150)
    half, twice = options.scaled(320), options.scaled(1280)
    assert (half.window, twice.window) == (5, 17)
    assert (half.min_object, twice.min_object) == (38, 600)


@pytest.mark.parametrize(
    ("width", "lengths", "areas"),
    [(320, (8, 80), (10, 38)), (1280, (32, 320), (160, 600)), (1, (1, 1), (1, 1))],
)
def test_constants_in_pixels_scale_with_width(width, lengths, areas):
    camera = CameraIntrinsics(width, width, 0.0, 0.0, width, 1)
    image = working_image(DepthFrame(np.ones((1, width), np.float32), camera))
    assert (image.length(16), image.length(160)) == lengths
    assert (image.area(40), image.area(150)) == areas


@given(width=st.integers(1, 5000))
def test_other_options_do_not_scale(width):
    scaled = DEFAULT.scaled(width)
    assert replace(scaled, window=DEFAULT.window, min_object=DEFAULT.min_object) == DEFAULT


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("stride", 2.0),
        ("min_object", 60.5),
        ("min_object", None),
        ("window", "9"),
        ("window", 9.5),
        ("median", 0),
        ("table_height", float("nan")),
    ],
)
def test_values_of_wrong_type_are_rejected(name, value):
    with pytest.raises(InputError, match=name):
        SegmentationOptions(**{name: value})
