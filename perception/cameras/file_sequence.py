"""Depth frames from a sequence of files, read one at a time."""

from __future__ import annotations

import re
from collections.abc import Generator, Iterable
from pathlib import Path

from eyehand.errors import InputError

from ..frame import DepthFrame
from ..io.depth_frame import FRAME_SUFFIXES, read_frame

WILDCARDS = "*?["
"""Characters of glob patterns."""

COLOUR_STEMS = re.compile(r"(?:(?P<depth>.+)_)?colou?r")
"""Names, without suffix, of colour images that lie beside the depth images they belong to."""


class FileSequence:
    """Frames of depth image files in natural order (a `Camera`): `f2.png` comes before `f10.png`.

    Parameters
    ----------
    source : Path, str, or iterable of them
        A folder, a pattern with ``*``, ``?``, ``[…]`` or ``**``, one file, or several files in any
        order. Colour images that belong to depth images (`f2_colour.png` beside `f2.png`) are
        skipped.
    camera : Path or str, optional
        Camera file for all frames. Without it, `read_frame` searches one beside each file.

    Raises
    ------
    InputError
        If a file does not exist, or the folder or pattern holds no frame file.
    """

    def __init__(
        self, source: Path | str | Iterable[Path | str], camera: Path | str | None = None
    ) -> None:
        files = _files(source) if isinstance(source, str | Path) else [Path(p) for p in source]
        if not files:
            raise InputError("a file sequence needs at least one file, got none")
        for path in files:
            if not path.is_file():
                raise InputError(f"{path}: no such file")
        self.paths = tuple(sorted(_without_colour(files), key=natural_key))
        """The files, in the order in which they are read."""
        self.camera = None if camera is None else Path(camera)
        """Camera file for all of them, or None."""

    def __len__(self) -> int:
        """Return the number of files."""
        return len(self.paths)

    def frames(self) -> Generator[DepthFrame, None, None]:
        """Read the files one after another.

        Raises
        ------
        InputError
            If a file cannot be read as a depth frame.
        """
        for path in self.paths:
            yield read_frame(path, self.camera)


def natural_key(path: Path) -> list[tuple[str, int]]:
    """Return a sort key that orders numbers in file names by value: f2 comes before f10."""
    pieces = re.findall(r"(\D*)(\d*)", str(path.with_suffix("")))
    return [(text, int(digits) if digits else -1) for text, digits in [*pieces, (path.suffix, "")]]


def _files(source: Path | str) -> list[Path]:
    path = Path(source)
    if path.is_dir():
        candidates = path.iterdir()
    elif any(c in str(source) for c in WILDCARDS) and not path.is_file():
        candidates = Path(path.anchor).glob(str(path.relative_to(path.anchor)))
    else:
        return [path]
    files = [
        p
        for p in candidates
        if p.suffix.lower() in FRAME_SUFFIXES and not p.name.startswith(".") and p.is_file()
    ]
    if not files:
        formats = ", ".join(FRAME_SUFFIXES)
        raise InputError(f"{source}: holds no depth frame files, expected some of {formats}")
    return files


def _without_colour(files: list[Path]) -> list[Path]:
    return [path for path in files if not _belongs_to_another(path, files)]


def _belongs_to_another(path: Path, files: list[Path]) -> bool:
    match = COLOUR_STEMS.fullmatch(path.stem)
    if match is None:
        return False
    if match["depth"] is not None:
        return path.with_stem(match["depth"]) in files
    # A file named colour.png belongs to the depth image in the same folder.
    return any(
        other.parent == path.parent and COLOUR_STEMS.fullmatch(other.stem) is None
        for other in files
    )
