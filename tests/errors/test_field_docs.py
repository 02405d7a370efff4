"""The docstrings of public dataclasses list the texts of their fields."""

import importlib
import inspect
import pydoc
from dataclasses import dataclass, fields

import pytest

from eyehand.errors import describe_fields


@pytest.mark.parametrize("package", ["perception", "grasping", "control", "tactile", "data_synth"])
def test_every_option_of_a_public_class_is_explained(package):
    module = importlib.import_module(f"eyehand.{package}")
    options = [getattr(module, name) for name in module.__all__ if name.endswith("Options")]
    assert options
    for value in options:
        text, _, listed = (inspect.getdoc(value) or "").partition("\n\nFields:\n")
        assert text
        assert {one.name for one in fields(value)} <= set(listed.splitlines())


def test_help_shows_the_text_of_a_field():
    from eyehand.grasping import PickOptions

    assert "Options of planning grasps of grippers with two jaws" in pydoc.render_doc(PickOptions)


def test_class_without_source_keeps_its_docstring():
    space: dict = {"dataclass": dataclass}
    exec('@dataclass\nclass Size:\n    """A size."""\n    width: float = 1.0', space)
    describe_fields(space["Size"], None, 3)
    assert space["Size"].__doc__ == "A size."
