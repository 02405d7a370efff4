"""Counts agree with their nouns, and progress shows without a terminal."""

import pytest

from eyehand.apps import console
from eyehand.apps.console import counted, plural, seed_span, tracked


def test_singular_for_one_and_plural_for_others():
    assert [counted(n, "scene") for n in (0, 1, 2)] == ["0 scenes", "1 scene", "2 scenes"]
    assert plural(1, "pick") == "pick"
    assert [seed_span(3, n) for n in (1, 2)] == ["seed 3", "seeds 3 to 4"]


@pytest.mark.parametrize("total", [3, None])
def test_progress_is_a_line_now_and_then_without_a_terminal(total, monkeypatch, capsys):
    assert list(tracked("abc", "reaching", total)) == ["a", "b", "c"]
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(console, "LINE_S", 0.0)
    assert list(tracked("abc", "reaching", total)) == ["a", "b", "c"]
    of = " of 3" if total else ""
    assert capsys.readouterr().err == "".join(f"reaching: {k}{of}\n" for k in (1, 2, 3))
