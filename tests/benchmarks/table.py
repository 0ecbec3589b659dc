"""The table of all figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from tests.benchmarks.figures import Figure


def show(machine: Mapping[str, Any], results: Mapping[str, Sequence[Figure]]) -> None:
    """Print what was measured, what is required, and the peers with how many times as good ours is."""
    console = Console(width=max(120, Console().width))
    versions = " · ".join(f"{name} {number}" for name, number in machine["versions"].items())
    facts = (machine["cpu"], f"{machine['cores']} cores", f"{machine['memory_gb']} GB", machine["system"])
    console.print(" · ".join(facts), highlight=False)
    console.print(versions, highlight=False)
    table = Table(header_style="bold")
    for column in ("benchmark", "what", "measured", "required", "peers (times as good)", "note"):
        table.add_column(column, justify="right" if column in ("measured", "required") else "left")
    for name, figures in results.items():
        for place, figure in enumerate(figures):
            table.add_row(
                name if place == 0 else "",
                figure.what,
                _measured(figure),
                _required(figure),
                "\n".join(_peer(figure, peer) for peer in figure.peers),
                figure.note,
                end_section=place == len(figures) - 1,
            )
    console.print(table)


def number(value: float) -> str:
    """Three significant digits, large numbers whole."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def _measured(figure: Figure) -> str:
    if figure.value is None:
        return "–"
    colour = {True: "green", False: "red", None: "default"}[figure.met]
    return f"[{colour}]{number(figure.value)} {figure.unit}[/]"


def _required(figure: Figure) -> str:
    sign = "≥" if figure.better == "more" else "≤"
    bounds = [] if figure.must is None else [f"{sign} {number(figure.must)} {figure.unit}"]
    return "\n".join(bounds + [f"≥ {ratio:g} × {peer}" for peer, ratio in figure.must_beat.items()])


def _peer(figure: Figure, peer: str) -> str:
    ratio = figure.ratio(peer)
    times = "" if ratio is None else f" (× {number(ratio)})"
    return f"{peer} {number(figure.peers[peer])}{times}"
