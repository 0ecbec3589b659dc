"""`particlecli new`: a scene to start from."""

from __future__ import annotations

from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Annotated

import typer

from particlecli.errors import OutputError, UsageError

_TEMPLATES = files("particlecli.scene") / "templates"


def templates() -> list[str]:
    """Names of the templates."""
    return sorted(Path(entry.name).stem for entry in _TEMPLATES.iterdir() if entry.name.endswith(".yaml"))


def command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The scene file to make; .yaml is added.")],
    template: Annotated[
        str,
        typer.Option("--from", metavar="TEMPLATE", help="sparks, fountain or smoke.", autocompletion=templates),
    ] = "sparks",
) -> None:
    """Make a commented scene to start from."""
    if template not in templates():
        near = get_close_matches(template, templates(), n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(templates())}"
        raise UsageError(f"no template {template!r}; {hint}")
    path = Path(name) if name.endswith((".yaml", ".yml")) else Path(f"{name}.yaml")
    text = (_TEMPLATES / f"{template}.yaml").read_text(encoding="utf-8")
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise UsageError(f"{path} exists already; it is left as it is") from None
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    typer.echo(f"made {path}; next: particlecli run {path}")
