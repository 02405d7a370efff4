"""Test settings that every folder shares."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from .browser import Page, open_page

# Equal runs for everybody: the examples follow from the test alone, and a kernel's first
# compilation may take as long as it takes.
settings.register_profile("eyehand", deadline=None, derandomize=True, database=None)
settings.load_profile("eyehand")

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def real_data() -> Path:
    """Folder of third-party frames beside the repository, or $EYEHAND_DATA; skips where absent."""
    folder = Path(os.environ.get("EYEHAND_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real frames at {folder}: set EYEHAND_DATA to their folder")
    return folder


@pytest.fixture(scope="session")
def tab(tmp_path_factory) -> Iterator[Page]:
    """Return the tab of a headless browser that all tests share; skips where none is installed."""
    with open_page(tmp_path_factory.mktemp("browser")) as page:
        yield page


@pytest.fixture
def browser(tab) -> Iterator[Page]:
    """Return a tab of a headless browser, and leave its page after the test.

    A page with a film or a 3D view is drawn on as long as it is open. Without a graphics card this
    takes a fifth of a core from the tests that follow.
    """
    yield tab
    tab.open("about:blank")
