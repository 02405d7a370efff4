"""Options refuse what no segmentation can do, and grow and shrink with the image."""

from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception import SegmentationOptions
from eyehand.perception.segmentation.options import MIN_WINDOW, REFERENCE_WIDTH

DEFAULT = SegmentationOptions()
NUMBERS = [
    field.name
    for field in fields(SegmentationOptions)
    if field.name != "table_height" and not isinstance(field.default, bool)
]
WHOLE = ["window", "stride", "threads", "line_samples", "min_patch", "min_object", "bend_reach"]


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_every_number_is_finite_and_positive(name, value):
    with pytest.raises(InputError, match=name):
        SegmentationOptions(**{name: value})


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_table_height_is_finite(value):
    with pytest.raises(InputError, match="table_height"):
        SegmentationOptions(table_height=value)


@pytest.mark.parametrize("value", [-0.7, 0.0, 0.9, None])
def test_a_table_may_stand_anywhere(value):
    assert SegmentationOptions(table_height=value).table_height == value


@pytest.mark.parametrize("name", ["stride", "threads", "line_samples"])
@pytest.mark.parametrize("value", [1.5, 2.001])
def test_what_is_counted_is_whole(name, value):
    with pytest.raises(InputError, match=f"{name} must be a whole number and > 0, got {value}"):
        SegmentationOptions(**{name: value})


@pytest.mark.parametrize("window", [1, 2, 8])
def test_a_window_has_a_middle_and_neighbours(window):
    with pytest.raises(InputError, match="window must be odd"):
        SegmentationOptions(window=window)


def test_at_the_reference_width_nothing_changes():
    assert DEFAULT.scaled(REFERENCE_WIDTH) == DEFAULT


@given(width=st.integers(1, 5000), window=st.integers(1, 20).map(lambda k: 2 * k + 1))
def test_scaled_options_are_valid_whole_pixels(width, window):
    scaled = SegmentationOptions(window=window).scaled(width)
    assert scaled.window % 2 == 1
    assert scaled.window >= MIN_WINDOW
    assert all(isinstance(getattr(scaled, name), int) for name in WHOLE)


def test_lengths_grow_with_the_width_and_areas_with_its_square():
    options = SegmentationOptions(
        window=9, gap_reach=16, hidden_reach=160, min_patch=40, min_object=150
    )
    half, twice = options.scaled(320), options.scaled(1280)
    assert (half.window, twice.window) == (5, 17)
    assert (half.gap_reach, twice.gap_reach) == (8, 32)
    assert (half.hidden_reach, twice.hidden_reach) == (80, 320)
    assert (half.min_patch, twice.min_patch) == (10, 160)
    assert (half.min_object, twice.min_object) == (38, 600)


@given(width=st.integers(1, 5000))
def test_metres_radians_sigmas_and_shares_do_not_scale(width):
    scaled = DEFAULT.scaled(width)
    pixels = {
        "window",
        "min_patch",
        "min_border",
        "bend_reach",
        "gap_reach",
        "hidden_reach",
        "min_hidden",
        "min_hollow",
        "fragment",
        "min_object",
    }
    kept = {name: getattr(scaled, name) for name in vars(DEFAULT) if name not in pixels}
    assert replace(DEFAULT, **kept) == DEFAULT


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("stride", 2.0),
        ("plane_candidates", 60.5),
        ("noise_quantile", 1.5),
        ("min_object", None),
        ("window", "9"),
        ("window", 9.5),
        ("median", 0),
        ("line_samples", 2000),
        ("table_height", float("nan")),
    ],
)
def test_values_of_the_wrong_kind_are_refused(name, value):
    with pytest.raises(InputError, match=name):
        SegmentationOptions(**{name: value})
