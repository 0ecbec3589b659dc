from __future__ import annotations

import json

from tests.cli.conftest import Cli


def test_schema_is_a_json_schema_of_scenes(cli: Cli) -> None:
    result = cli("schema")
    assert result.returncode == 0
    schema = json.loads(result.stdout)
    assert "json-schema.org" in schema["$schema"]
    assert {"emitters", "forces", "outputs"} <= set(schema["properties"])


def test_markdown_is_the_reference(cli: Cli) -> None:
    result = cli("schema", "--markdown")
    assert result.returncode == 0
    assert "# The scene language" in result.stdout
    assert "| `duration` |" in result.stdout
