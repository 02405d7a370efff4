"""`eyehand synth`: families, empty tables and rejected input."""

import json

import pytest

from eyehand.apps.main import main


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Run a command in this process; return exit code, stdout and stderr."""
    with pytest.raises(SystemExit) as exit_info:
        main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    return int(exit_info.value.code or 0), printed.out, printed.err


@pytest.mark.parametrize("family", ["dropped", "piled"])
def test_synth_makes_the_named_family(tmp_path, capsys, family):
    arguments = ["synth", "--family", family, "--objects", "2", "--out", tmp_path, "--json"]
    code, out, _ = run(*arguments, capsys=capsys)
    assert code == 0
    assert len(json.loads(out)["rows"]) == 2
    assert json.loads((tmp_path / "ground_truth.json").read_text())["family"] == family


def test_zero_objects_give_an_empty_table(tmp_path, capsys):
    code, out, _ = run("synth", "--objects", "0", "--out", tmp_path, "--json", capsys=capsys)
    assert code == 0
    assert json.loads(out)["rows"] == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--family", "piled", "--objects", "1"], "2 to 15 for the family piled, got 1"),
        (["--family", "dropped", "--objects", "0"], "1 to 15 for the family dropped, got 0"),
        (["--family", "heaped"], "heaped"),
    ],
)
def test_invalid_family_or_count_is_rejected(tmp_path, capsys, arguments, message):
    code, out, err = run("synth", *arguments, "--out", tmp_path / "none", capsys=capsys)
    assert code == 2
    assert out == ""
    assert message in err
    assert not (tmp_path / "none").exists()
