"""Docstrings of dataclasses that list their fields, for `help()`.

The text of a field stands below it in the source. Python does not keep it.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from contextlib import suppress
from dataclasses import is_dataclass
from itertools import pairwise

HEADING = "Fields:"
"""Line between the docstring of a class and its fields."""


def describe_fields(*values: object) -> None:
    """Extend the docstrings of those values that are dataclasses by the texts of their fields.

    The source is read when a docstring is asked for. Without it, the docstring stays as it is.
    """
    for value in values:
        if isinstance(value, type) and is_dataclass(value):
            text = vars(value)["__doc__"]
            if isinstance(text, str):
                value.__doc__ = _FieldDocs(text)  # pyright: ignore[reportAttributeAccessIssue]


class _FieldDocs:
    """A docstring that is completed when it is asked for."""

    def __init__(self, text: str) -> None:
        self.text = inspect.cleandoc(text)

    def __get__(self, instance: object, owner: type) -> str:
        fields = [f"{name}\n{textwrap.indent(text, '    ')}" for name, text in _texts(owner)]
        return "\n".join([self.text, "", HEADING, *fields] if fields else [self.text])


def _texts(owner: type) -> list[tuple[str, str]]:
    """Return names and texts of the documented fields of a class and its bases."""
    found: dict[str, str] = {}
    for base in reversed(owner.__mro__):
        with suppress(OSError, TypeError):
            tree = ast.parse(textwrap.dedent(inspect.getsource(base))).body[0]
            for field, text in pairwise(tree.body if isinstance(tree, ast.ClassDef) else []):
                if (
                    isinstance(field, ast.AnnAssign)
                    and isinstance(text, ast.Expr)
                    and isinstance(text.value, ast.Constant)
                ):
                    found[ast.unparse(field.target)] = inspect.cleandoc(str(text.value.value))
    return list(found.items())
