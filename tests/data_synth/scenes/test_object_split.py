"""The halves of household objects: alternating names, and the committed list."""

from __future__ import annotations

from pathlib import Path

import pytest

from eyehand.data_synth.scenes import select_half
from eyehand.data_synth.scenes.object_folder import half_of
from eyehand.errors import InputError

ROOT = Path(__file__).resolve().parents[3]
OBJECTS = ROOT.parent / "shared" / "data" / "objects"
LIST = ROOT / "docs" / "household_objects.md"


def test_halves_alternate_and_names_of_both_folders_keep_theirs():
    assert half_of(["c", "a", "b", "a"]) == {
        "a": "development",
        "b": "held-out",
        "c": "development",
    }
    assert half_of(["mug", "a"])["mug"] == half_of(["mug"])["mug"] == "held-out"


def test_halves_are_disjoint_and_complete():
    names = [f"object_{k}" for k in range(7)]
    halves = [select_half(names, names, split) for split in ("development", "held-out")]
    assert sorted([*halves[0], *halves[1]]) == names
    assert select_half(names, names, "all") == tuple(names)


def test_empty_half_raises():
    with pytest.raises(InputError, match="none is held-out"):
        select_half(["a"], ["a"], "held-out")


@pytest.mark.parametrize("folder", ["packed", "pile"])
def test_committed_list_holds_the_halves_of_the_data(folder):
    if not OBJECTS.is_dir():
        pytest.skip(f"{OBJECTS} is missing")
    halves = half_of([path.stem for path in (OBJECTS / folder).glob("*.urdf")])
    text = LIST.read_text()
    for name, half in halves.items():
        assert f"| {folder} | {half} | `{name}` |" in text
