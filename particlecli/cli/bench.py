"""`particlecli bench`: error against speed of integrators on a scene."""

from __future__ import annotations

import json as json_module
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar, get_args

import typer

from particlecli.cli.console import message
from particlecli.cli.options import OutputFolder, Overrides, Quiet, SceneFile, Threads
from particlecli.cli.scenes import load
from particlecli.errors import UsageError

if TYPE_CHECKING:
    from particlecli.accuracy.curves import WorkPrecision
    from particlecli.scene.integrator import Scheme

Number = TypeVar("Number", int, float)

Integrators = Annotated[
    str | None,
    typer.Option("--integrators", metavar="A,B,…", help="Integrators to try.  [default: all that suit the scene]"),
]
Steps = Annotated[
    str | None,
    typer.Option("--steps", metavar="N,N,…", help="Equal steps in a frame.  [default: doubled while it pays]"),
]
Tolerances = Annotated[
    str | None,
    typer.Option(
        "--tolerances", metavar="T,T,…", help="Of adaptive integrators.  [default: ever smaller while it pays]"
    ),
]
Particles = Annotated[
    int | None,
    typer.Option(
        "--particles", metavar="N", min=1, help="Particles of each group to simulate, at most.  [default: up to 20,000]"
    ),
]
Budget = Annotated[
    float,
    typer.Option("--budget", metavar="S", min=1.0, help="Seconds that all may take, about; what is left out is said."),
]
Longest = Annotated[
    float, typer.Option("--longest", metavar="S", min=0.01, help="Seconds that one run may take, about.")
]
Peers = Annotated[bool, typer.Option("--peers/--no-peers", help="Let SciPy's integrators run too.")]


def command(
    scene: SceneFile,
    integrators: Integrators = None,
    steps: Steps = None,
    tolerances: Tolerances = None,
    particles: Particles = None,
    budget: Budget = 120.0,
    longest: Longest = 1.0,
    peers: Peers = True,
    folder: OutputFolder = None,
    overrides: Overrides = None,
    threads: Threads = None,
    json: Annotated[bool, typer.Option("--json", help="Print what bench.json holds, as one JSON object.")] = False,
    quiet: Quiet = False,
) -> None:
    """Measure error against speed of integrators on a scene.

    Each integrator runs at many steps or tolerances, in double precision and in the scene's own; a converged
    solution tells the error. Writes bench.json and the work-precision plot bench.svg and bench.png.
    """
    loaded = load(scene, overrides)
    from particlecli.accuracy.work_precision import Study, work_precision

    study = Study(
        integrators=_schemes(integrators),
        steps=_numbers("--steps", steps, int),
        tolerances=_numbers("--tolerances", tolerances, float),
        particles=particles,
        budget=budget,
        longest=longest,
        peers=peers,
        threads=threads,
    )
    with _files(folder or Path("outputs") / loaded.name) as write, _progress(quiet) as show:
        result = work_precision(loaded, study, show)
        files = write(result)
    if json:
        typer.echo(json_module.dumps(result.to_dict(), indent=2, ensure_ascii=False))
    else:
        from particlecli.cli.bench_table import show_table

        show_table(result, files)


def _schemes(text: str | None) -> tuple[Scheme, ...] | None:
    """Integrators by name.

    Raises:
        UsageError: there is none of that name.
    """
    if text is None:
        return None
    from particlecli.scene.integrator import Scheme
    from particlecli.scene.messages import suggestion

    known = get_args(Scheme)
    for name in text.split(","):
        if name not in known:
            raise UsageError(f'--integrators: there is no "{name}"{suggestion(name, known)}')
    return tuple(name for name in known if name in text.split(","))


def _numbers(option: str, text: str | None, kind: Callable[[str], Number]) -> tuple[Number, ...] | None:
    """Positive numbers between commas.

    Raises:
        UsageError: they are not.
    """
    if text is None:
        return None
    try:
        numbers = tuple(kind(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if not numbers or not all(0 < number < float("inf") for number in numbers):
        raise UsageError(f"{option} takes positive {'whole ' * (kind is int)}numbers with commas between, not {text}")
    return numbers


@contextmanager
def _files(folder: Path) -> Iterator[Callable[[WorkPrecision], Sequence[Path]]]:
    """What writes bench.json and the plots into a folder; finds out at once whether that is possible."""
    from particlecli.sinks.pending import Pending, within, writing

    pending = [Pending(within(folder, f"bench.{ending}")) for ending in ("json", "svg", "png")]

    def write(result: WorkPrecision) -> Sequence[Path]:
        from particlecli.accuracy.work_precision_plot import save_plot

        data, *plots = pending
        with writing(data.path):
            text = json_module.dumps(result.to_dict(), indent=2, ensure_ascii=False)
            data.temporary.write_text(text + "\n", encoding="utf-8")
        with writing(plots[0].path):
            save_plot(result, [plot.temporary for plot in plots])
        for each in pending:
            each.commit()
        return [folder / each.path.name for each in pending]

    try:
        for each in pending:
            each.claim()
        yield write
    finally:
        for each in reversed(pending):
            each.discard()


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[str], None]]:
    """What tells on stderr what is being tried."""
    import sys

    if quiet:
        yield lambda _: None
    elif sys.stderr.isatty():
        from rich.console import Console

        with Console(stderr=True).status("compiling") as status:
            yield lambda text: status.update(text)
    else:
        yield message
