"""Charts: complete files and readable axes."""

import csv

import cv2
import numpy as np
import pytest

from eyehand.apps.bench.chart_style import (
    Provenance,
    add_footer,
    add_legend,
    draw_curve,
    format_time,
    label_axes,
    new_chart,
    set_percent_axis,
    set_time_axis,
    write_chart,
)
from eyehand.apps.bench.machine import core_count, machine_line
from eyehand.errors import InputError


def test_writes_picture_and_table(tmp_path):
    figure, axes = new_chart("Noise", "F against noise", columns=2, height=4.0)
    for panel in axes:
        draw_curve(panel, [0, 1, 2], [99, 98, 50], "separate")
        label_axes(panel, "noise (mm)", "overlap F", panel="separate")
        set_percent_axis(panel, 0, 100)
        add_legend(panel)
    add_footer(figure, Provenance("made-up figures", seed=3, frames=20))
    path = tmp_path / "noise.png"
    write_chart(figure, path, [{"noise_mm": 0, "f_pct": 99.5}, {"noise_mm": 1, "note": "ä, b"}])
    picture = cv2.imread(str(path))
    assert picture is not None
    assert picture.shape == (800, 1600, 3)
    assert picture.min() < 60  # something is drawn
    with path.with_suffix(".csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows == [
        {"noise_mm": "0", "f_pct": "99.5", "note": ""},
        {"noise_mm": "1", "f_pct": "", "note": "ä, b"},
    ]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["noise.csv", "noise.png"]


def test_footer_names_seed_frames_and_machine():
    figure, _ = new_chart("Title", "subtitle")
    add_footer(figure, Provenance("real frames", seed=None, frames=1))
    footer = figure.texts[-1].get_text()
    assert footer == f"real frames; 1 frame, no randomness\n{machine_line()}"
    assert f"{core_count()} cores" in footer


@pytest.mark.parametrize(
    ("milliseconds", "text"),
    [(0.5, "0.5 ms"), (20, "20 ms"), (1000, "1 s"), (2500, "2.5 s"), (60e3, "1 min")],
)
def test_formats_times(milliseconds, text):
    assert format_time(milliseconds) == text


def test_time_axis_is_logarithmic_with_round_labels():
    _, axes = new_chart("Title", "subtitle")
    set_time_axis(axes[0], 8, 1500)
    labels = [label.get_text() for label in axes[0].get_xticklabels()]
    assert labels == ["10 ms", "20 ms", "50 ms", "100 ms", "200 ms", "500 ms", "1 s"]


def test_stretched_axis_is_logarithmic_in_error():
    _, axes = new_chart("Title", "subtitle")
    set_percent_axis(axes[0], 40, 98, stretched=True)
    heights = axes[0].transData.transform([(0, 80), (0, 90), (0, 95)])[:, 1]
    assert np.diff(heights)[0] == pytest.approx(np.diff(heights)[1])
    assert "90 %" in [label.get_text() for label in axes[0].get_yticklabels()]


def test_rejects_invalid_charts(tmp_path):
    figure, axes = new_chart("Title", "subtitle")
    with pytest.raises(InputError, match=r"\.png"):
        write_chart(figure, tmp_path / "chart.pdf", [{"a": 1}])
    with pytest.raises(InputError, match="no rows"):
        write_chart(figure, tmp_path / "chart.png", [])
    with pytest.raises(InputError, match="above 0"):
        set_time_axis(axes[0], 0, 10)
    with pytest.raises(InputError, match="below 100"):
        set_percent_axis(axes[0], 40, 100, stretched=True)
    with pytest.raises(InputError, match="do not fit"):
        new_chart("Title", "subtitle", rows=5, height=3.0)
    assert not list(tmp_path.iterdir())
