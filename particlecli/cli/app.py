"""The command `particlecli`: its subcommands, `--version` and what happens to errors."""

from __future__ import annotations

import signal
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from particlecli import __version__
from particlecli.cli import (
    analyze,
    batch,
    bench,
    check,
    console,
    explain,
    gallery,
    inspect,
    new,
    run,
    schema,
    validate,
    view,
)
from particlecli.interruption import stop_on


class Commands(TyperGroup):
    """The subcommands; their errors become messages and exit codes."""

    def invoke(self, ctx: Any) -> Any:
        """Runs the chosen subcommand."""
        with console.errors_become_messages():
            return super().invoke(ctx)


app = typer.Typer(
    cls=Commands,
    help="Particle dynamics from YAML scenes: pictures, videos and recordings.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"particlecli {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


app.command("run")(run.command)
app.command("validate")(validate.command)
app.command("explain")(explain.command)
app.command("analyze")(analyze.command)
app.command("bench")(bench.command)
app.command("check")(check.command)
app.command("batch")(batch.command)
app.command("gallery")(gallery.command)
app.command("inspect")(inspect.command)
app.command("view")(view.command)
app.command("new")(new.command)
app.command("schema")(schema.command)


def run_app() -> None:
    """Runs the command line and exits with a code, however it ends."""
    with console.bugs_become_messages():
        app(prog_name="particlecli")


def main() -> None:
    """Runs the command line as a program, which signals stop."""
    stop_on(signal.SIGINT, signal.SIGTERM)
    run_app()
