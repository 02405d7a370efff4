"""The header of a PLY file: its tables, their columns, and the pixel grid."""

from __future__ import annotations

from dataclasses import dataclass, field

from eyehand.errors import InputError

from .point_table import whole_number

SCALARS = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
"""Property types of PLY and their names in NumPy."""

BYTE_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
"""The three formats of the body, as in the format line, and their byte orders in NumPy."""

GRID_WORDS = {"num_cols": "width", "width": "width", "num_rows": "height", "height": "height"}
"""Words of `obj_info` and `comment` lines that give the size of the pixel grid."""

MAX_HEADER_BYTES = 1 << 20
"""Maximum length of a header. A file without `end_header` up to here is not PLY."""


@dataclass(frozen=True)
class PlyProperty:
    """One column of a table."""

    name: str
    """Name of the column."""
    kind: str
    """NumPy type code, without byte order."""
    count_kind: str = ""
    """NumPy type code of the list length before each entry; empty if entries are no lists."""


@dataclass
class PlyElement:
    """One table of the file."""

    name: str
    """Name of the table."""
    count: int
    """Number of its rows."""
    properties: list[PlyProperty] = field(default_factory=list)
    """Columns, in order."""

    @property
    def has_lists(self) -> bool:
        """Whether rows differ in length."""
        return any(p.count_kind for p in self.properties)


@dataclass
class PlyHeader:
    """The parsed header of a PLY file."""

    form: str = ""
    """A key of `BYTE_ORDERS`."""
    elements: list[PlyElement] = field(default_factory=list)
    """Tables of the file, in order."""
    grid: dict[str, int] = field(default_factory=dict)
    """`width` and `height` of the pixel grid, px, if the file has them."""
    body_at: int = 0
    """Offset of the data, bytes."""

    @property
    def byte_order(self) -> str:
        """NumPy code of the byte order of the data."""
        return BYTE_ORDERS[self.form]

    def element(self, name: str) -> PlyElement | None:
        """Return the table of a name, or None."""
        return next((e for e in self.elements if e.name == name), None)


def parse_ply_header(data: bytes) -> PlyHeader:
    """Parse the header of a PLY file.

    Raises
    ------
    InputError
        If the bytes do not begin with a complete PLY header.
    """
    if data[:3] != b"ply" or data[3:4] not in (b"\n", b"\r"):
        raise InputError(f"not a PLY file: it begins with {data[:8]!r}, expected b'ply'")
    at = data.find(b"end_header", 0, MAX_HEADER_BYTES)
    newline = data.find(b"\n", at)
    if at < 0 or newline < 0:
        raise InputError("not a whole PLY file: its header has no end_header line")
    header = PlyHeader(body_at=newline + 1)
    for line in data[3:at].decode("latin-1").splitlines():
        words = line.split()
        if words:
            _parse_line(header, words)
    if header.form not in BYTE_ORDERS:
        raise InputError(f"the PLY format is {header.form!r}, expected one of {list(BYTE_ORDERS)}")
    return header


def _parse_line(header: PlyHeader, words: list[str]) -> None:
    match words:
        case ["format", form, *_]:
            header.form = form
        case ["element", name, count]:
            header.elements.append(PlyElement(name, _count(count, name)))
        case ["property", kind, name] if header.elements and kind in SCALARS:
            header.elements[-1].properties.append(PlyProperty(name, SCALARS[kind]))
        case ["property", "list", count, kind, name] if (
            header.elements and kind in SCALARS and SCALARS.get(count, "f")[0] != "f"
        ):
            header.elements[-1].properties.append(PlyProperty(name, SCALARS[kind], SCALARS[count]))
        case ["obj_info" | "comment", word, size] if word in GRID_WORDS:
            if (number := whole_number(size)) is not None:
                header.grid[GRID_WORDS[word]] = number
        case ["obj_info" | "comment", *_]:
            pass
        case _:
            raise InputError(f"the PLY header has {' '.join(words)[:60]!r}, which is not PLY")


def _count(word: str, name: str) -> int:
    number = whole_number(word)
    if number is None:
        raise InputError(f"the PLY header has element {name} {word[:40]}, expected a whole number")
    return number
