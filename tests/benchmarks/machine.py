"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil

from particlecli import __version__

LIBRARIES = ("taichi", "numpy", "warp-lang", "imageio-ffmpeg")


def machine() -> dict[str, Any]:
    """Facts about the machine: cores, CPU model, memory, system, versions, and how busy others keep it."""
    return {
        "cpu": _cpu_model(),
        "cores": os.cpu_count(),
        "memory_gb": round(psutil.virtual_memory().total / 1e9, 1),
        "system": f"{platform.system()} {platform.machine()}",
        "versions": _versions(),
    }


def load() -> dict[str, float]:
    """How busy the machine is now: runnable processes a core, and the share of time the host takes away."""
    one_minute = os.getloadavg()[0] / (os.cpu_count() or 1)
    stolen = getattr(psutil.cpu_times_percent(interval=0.5), "steal", 0.0)
    return {"runnable_per_core": round(one_minute, 2), "stolen_percent": stolen}


def _cpu_model() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()


def _versions() -> dict[str, str]:
    found = {"particlecli": __version__, "python": platform.python_version()}
    for library in LIBRARIES:
        try:
            found[library] = version(library)
        except PackageNotFoundError:
            continue
    if compiler := shutil.which("g++"):
        run = subprocess.run([compiler, "-dumpfullversion"], capture_output=True, text=True, check=False)
        found["g++"] = run.stdout.strip()
    return found
