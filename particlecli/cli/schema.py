"""`particlecli schema`: the scene language, for editors and for people."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def command(
    markdown: Annotated[bool, typer.Option("--markdown", help="The reference of all keys, to read.")] = False,
) -> None:
    """Print the JSON Schema of scenes.

    Editors complete and check YAML with it: save it as scene.schema.json beside a scene that begins with
    `# yaml-language-server: $schema=scene.schema.json`.
    """
    from particlecli.scene import reference

    typer.echo(reference.markdown() if markdown else json.dumps(reference.json_schema(), indent=2))
