"""Settings of the chart: the default first, every dial alone, no duplicates."""

from dataclasses import replace

from eyehand.apps.segmentation.chart import BOARD, STAGES
from eyehand.perception import SegmentationOptions


def test_default_is_first_and_settings_are_unique():
    settings = BOARD.settings()
    assert settings[0].name == "default"
    assert settings[0].options == SegmentationOptions()
    assert len({setting.name for setting in settings}) == len(settings)
    assert len({setting.options for setting in settings}) == len(settings)


def test_every_value_of_every_dial_occurs_alone():
    options = {setting.options for setting in BOARD.settings()}
    for key, values in BOARD.dials.items():
        for value in values:
            assert replace(SegmentationOptions(), **{key: value}) in options


def test_setting_names_state_the_difference():
    assert BOARD.setting({"stride": 2, "window": 7}).name == "stride 2, window 7"
    assert BOARD.setting({"threads": 2, "shift_windows": False}).name == "2 threads, no shift"
    assert BOARD.setting({"stride": 4, **STAGES}).name == "stride 4, bare"


def test_bare_switches_off_all_optional_stages():
    assert {key for key in BOARD.dials if getattr(SegmentationOptions(), key) is True} == set(
        STAGES
    )


def test_all_dials_restore_options():
    for setting in BOARD.settings(quick=True):
        assert replace(SegmentationOptions(), **setting.all_dials()) == setting.options


def test_quick_settings_are_a_subset():
    quick, full = BOARD.settings(quick=True), BOARD.settings()
    assert 3 <= len(quick) < len(full) / 4
    assert {setting.options for setting in quick} <= {setting.options for setting in full}
