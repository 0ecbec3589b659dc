"""python -m tests.benchmarks [NAME …]: measures, prints one table, writes outputs/benchmarks.json.

Each benchmark runs in a process of its own: one Taichi runtime a process, and none inherits another's memory.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import traceback
from concurrent.futures import ProcessPoolExecutor
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from tests.benchmarks.figures import Figure, measure
from tests.benchmarks.machine import load, machine
from tests.benchmarks.table import show

NAMES = (
    "simulate",
    "rk4",
    "memory",
    "render",
    "bodies",
    "blobs",
    "campfire",
    "recording",
    "pleiades",
    "attraction",
    "barnes_hut",
    "lennard_jones",
    "sph",
    "cloth",
    "estimate",
    "help",
    "scaling",
)
RESULTS = Path(__file__).parents[2] / "outputs" / "benchmarks.json"

SILENCE = {"ENABLE_TAICHI_HEADER_PRINT": "0", "TI_LOG_LEVEL": "error"}
"""Peers import Taichi before the engine can silence it."""


def main() -> None:
    """Runs the benchmarks named on the command line, or all."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(NAMES))
    names = parser.parse_args().names or NAMES
    if unknown := [name for name in names if name not in NAMES]:
        parser.error(f"no benchmark {unknown[0]}; there are {', '.join(NAMES)}")
    os.environ |= SILENCE
    facts = machine()
    results: dict[str, list[Figure]] = {}
    record = _record()
    for name in names:
        print(f"{name} …", file=sys.stderr, flush=True)
        busy = load()
        results[name] = _measured(name)
        record[name] = {
            "measured": datetime.now(UTC).isoformat(timespec="seconds"),
            "machine": {**facts, "load_before": busy},
            "figures": [figure.to_dict() for figure in results[name]],
        }
        RESULTS.parent.mkdir(exist_ok=True)
        RESULTS.write_text(json.dumps(record, indent=2, ensure_ascii=False) + "\n")
    show(facts, results)


def _measured(name: str) -> list[Figure]:
    """The figures of a benchmark from a process of its own; if it fails, why, and the others go on."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        try:
            return process.submit(measure, name).result()
        except Exception as error:
            traceback.print_exception(error)
            reason = f"failed: {type(error).__name__}: {error}"
            return [Figure(name, None, "", "less", note=reason.strip().partition("\n")[0])]


def _record() -> dict[str, Any]:
    """What earlier runs measured; a run of some benchmarks leaves the others' figures."""
    return json.loads(RESULTS.read_text()) if RESULTS.exists() else {}


if __name__ == "__main__":
    main()
