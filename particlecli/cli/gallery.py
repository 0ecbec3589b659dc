"""`particlecli gallery`: all shipped scenes on one page."""

from __future__ import annotations

from pathlib import Path

from particlecli.cli.batch import AsJson, Folder, Force, Jobs, PictureQuality, carry_out
from particlecli.cli.options import Quiet
from particlecli.errors import UsageError

_PACKAGE = Path(__file__).parents[1]

PLACES = (_PACKAGE / "shipped", _PACKAGE.parent / "scenes")
"""Where scenes are in an installed package, and in a checkout."""


def command(
    folder: Folder = Path("outputs/gallery"),
    jobs: Jobs = None,
    force: Force = False,
    quality: PictureQuality = "final",
    json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Render every shipped scene, and make a page of them.

    As a batch: what is up to date is not rendered again.
    """
    from particlecli.batch.jobs import make_jobs

    made = make_jobs(shipped_scenes(), [], folder, quality)
    carry_out(made, folder, title="particlecli gallery", processes=jobs, force=force, json=json, quiet=quiet)


def shipped_scenes() -> list[Path]:
    """The scenes that come with the package.

    Raises:
        UsageError: there are none.
    """
    for place in PLACES:
        if scenes := sorted(place.glob("*.yaml")):
            return scenes
    raise UsageError(f"the scenes are missing from this installation; they should be in {PLACES[0]}")
