"""`eyehand synth` makes every family, and an empty table."""

import json

import pytest

from eyehand.apps.main import main


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command run in this process."""
    with pytest.raises(SystemExit) as leaving:
        main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    return int(leaving.value.code or 0), printed.out, printed.err


@pytest.mark.parametrize("family", ["dropped", "piled"])
def test_objects_that_fell_are_made_by_name(tmp_path, capsys, family):
    arguments = ["synth", "--family", family, "--objects", "2", "--out", tmp_path, "--json"]
    code, out, _ = run(*arguments, capsys=capsys)
    assert code == 0
    assert len(json.loads(out)["rows"]) == 2
    assert json.loads((tmp_path / "ground_truth.json").read_text())["family"] == family


def test_no_objects_are_an_empty_table(tmp_path, capsys):
    code, out, _ = run("synth", "--objects", "0", "--out", tmp_path, "--json", capsys=capsys)
    assert code == 0
    assert json.loads(out)["rows"] == []


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--family", "piled", "--objects", "1"], "2 to 15 for the family piled, got 1"),
        (["--family", "dropped", "--objects", "0"], "1 to 15 for the family dropped, got 0"),
        (["--family", "heaped"], "heaped"),
    ],
)
def test_a_family_or_count_that_is_none_is_refused_in_words(tmp_path, capsys, arguments, told):
    code, out, err = run("synth", *arguments, "--out", tmp_path / "none", capsys=capsys)
    assert code == 2
    assert out == ""
    assert told in err
    assert not (tmp_path / "none").exists()
