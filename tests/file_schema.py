"""Check JSON files against the schema that the documentation shows."""

import json
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

SCHEMA = json.loads(
    (Path(__file__).resolve().parents[1] / "docs" / "files.schema.json").read_text()
)


def closed(schema: Any) -> Any:
    """Return a schema that accepts no members besides the described ones.

    The published schema accepts them, because files of later versions may have more members. The
    tests do not: each member that a command writes must be described.
    """
    if isinstance(schema, list):
        return [closed(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    inner = {name: closed(one) for name, one in schema.items()}
    described = isinstance(schema.get("properties"), dict) and "object" in schema.get("type", ())
    return {"additionalProperties": False, **inner} if described else inner


DEFS = closed(SCHEMA["$defs"])


def check_file(content: Any, name: str) -> None:
    """Check the content of a file, or the path of one, against ``$defs/<name>``.

    Raises
    ------
    jsonschema.ValidationError
        If a member is missing, unknown, or of another type.
    """
    if isinstance(content, Path):
        content = json.loads(content.read_text())
    Draft202012Validator({"$ref": f"#/$defs/{name}", "$defs": DEFS}).validate(content)
