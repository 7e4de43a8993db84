"""The JSON schemas of what each verb prints with --json."""

import json
from pathlib import Path
from typing import Any

import narrows
from _extension.markdown import table

FOLDER = Path(narrows.__file__).parent / "schemas"


def text() -> str:
    """Write what each verb prints: its members, and the schema whole."""
    return "\n\n".join(
        _page(path.stem, json.loads(path.read_text(encoding="utf-8"))) for path in sorted(FOLDER.glob("*.json"))
    )


def _page(verb: str, schema: dict[str, Any]) -> str:
    whole = json.dumps(schema, indent=2, ensure_ascii=False)
    return f"## {verb}\n\n{_members(schema)}\n\n````{{dropdown}} {verb}.json\n```json\n{whole}\n```\n````"


def _members(schema: dict[str, Any]) -> str:
    members, required = schema.get("properties", {}), schema.get("required", ())
    if not members:
        return _type(schema)
    rows = (
        (f"`{name}`", _type(own), "" if name in required else "at times", own.get("description", ""))
        for name, own in members.items()
    )
    return table(("member", "type", "present", "what it is"), ((n, t, p or "always", d) for n, t, p, d in rows))


def _type(schema: dict[str, Any]) -> str:
    if "enum" in schema:
        return "one of " + ", ".join(json.dumps(value) for value in schema["enum"])
    if "$ref" in schema:
        return f"as `{schema['$ref'].rpartition('/')[2]}`"
    kinds = schema.get("type", "any of several")
    return kinds if isinstance(kinds, str) else " or ".join(kinds)
