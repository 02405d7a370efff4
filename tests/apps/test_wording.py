"""Counts agree with their nouns."""

from eyehand.apps.console import counted, plural, seed_span


def test_singular_for_one_and_plural_for_others():
    assert [counted(n, "scene") for n in (0, 1, 2)] == ["0 scenes", "1 scene", "2 scenes"]
    assert plural(1, "pick") == "pick"
    assert [seed_span(3, n) for n in (1, 2)] == ["seed 3", "seeds 3 to 4"]
