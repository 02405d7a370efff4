"""Check JSON files against the schema that the documentation shows."""

import json
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

SCHEMA = json.loads(
    (Path(__file__).resolve().parents[1] / "docs" / "files.schema.json").read_text()
)


def check_file(content: Any, name: str) -> None:
    """Check the content of a file, or the path of one, against ``$defs/<name>``.

    Raises
    ------
    jsonschema.ValidationError
        If a member is missing, unknown, or of another type.
    """
    if isinstance(content, Path):
        content = json.loads(content.read_text())
    Draft202012Validator({"$ref": f"#/$defs/{name}", "$defs": SCHEMA["$defs"]}).validate(content)
