"""The page of a batch: one HTML file that shows what came out of each job. It loads nothing from elsewhere."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

from particlecli.batch.thumbnail import VIDEOS, thumbnail

EMBEDDED_BYTES = 48 << 20
"""Videos are put into the page until they are so large together; the others are played from beside it."""

_KINDS = {".mp4": "video/mp4", ".webm": "video/webm", ".gif": "image/gif"}

_STYLE = """
:root { color-scheme: light dark; --line: #8884; --soft: #8882; --bad: #d33; }
* { box-sizing: border-box; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 1500px; padding: 1.5rem; }
h1 { font-size: 1.5rem; margin: 0; }
h2 { font-size: 1.05rem; margin: 0; overflow-wrap: anywhere; }
p { margin: .3rem 0; }
main { display: grid; gap: 1.2rem; grid-template-columns: repeat(auto-fill, minmax(330px, 1fr)); margin-top: 1.2rem; }
article { border: 1px solid var(--line); border-radius: 10px; overflow: hidden; display: flex; flex-direction: column; }
article.failed { border-color: var(--bad); }
video, img, .nothing { width: 100%; aspect-ratio: 16 / 9; object-fit: contain; background: #05060a; display: block; }
.nothing { display: grid; place-items: center; color: #99a; }
.about { padding: .8rem 1rem 1rem; }
.job { opacity: .65; font-size: .85rem; overflow-wrap: anywhere; }
.error { color: var(--bad); white-space: pre-wrap; overflow-wrap: anywhere; }
table { border-collapse: collapse; margin-top: .5rem; width: 100%; font-size: .85rem; }
td { border-top: 1px solid var(--soft); padding: .18rem .4rem .18rem 0; vertical-align: top; overflow-wrap: anywhere; }
td:first-child { opacity: .65; white-space: nowrap; }
.value td { font-weight: 600; }
a { color: inherit; }
"""


def page(title: str, entries: Mapping[str, dict[str, Any]], folder: Path) -> str:
    """The HTML text.

    Args:
        title: heading.
        entries: of a manifest, by job.
        folder: where the page will be; files of reports are relative to it.
    """
    album = _Album(folder)
    count = f"{len(entries)} {'run' if len(entries) == 1 else 'runs'}" + _failed(entries)
    cards = "\n".join(_card(name, entry, album) for name, entry in entries.items())
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{_STYLE}</style>
</head>
<body>
<header><h1>{escape(title)}</h1><p>{count}</p></header>
<main>
{cards}
</main>
</body>
</html>
"""


class _Album:
    """Pictures and videos as a page shows them."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._room = EMBEDDED_BYTES

    def shown(self, report: dict[str, Any], what: str) -> str:
        """The video of a run, else a picture of it, else words."""
        files = [self._folder / file for file in report["files"]]
        small = thumbnail(files, report["duration"])
        poster = "" if small is None else _inline("image/jpeg", small)
        video = next((file for file in files if file.suffix.lower() in VIDEOS and file.is_file()), None)
        if video is None:
            return f'<img src="{poster}" alt="{what}">' if poster else '<div class="nothing">no pictures</div>'
        if video.suffix.lower() == ".gif":
            return f'<img src="{self._source(video)}" alt="{what}">'
        preload = f'poster="{poster}" preload="none"' if poster else 'preload="metadata"'
        return f'<video controls loop muted playsinline {preload} src="{self._source(video)}" title="{what}"></video>'

    def _source(self, video: Path) -> str:
        size = video.stat().st_size
        if size > self._room:
            return quote(video.relative_to(self._folder).as_posix())
        self._room -= size
        return _inline(_KINDS[video.suffix.lower()], video.read_bytes())


def _inline(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _failed(entries: Mapping[str, dict[str, Any]]) -> str:
    """How many runs failed, with links to them."""
    names = [name for name, entry in entries.items() if entry["status"] == "failed"]
    links = ", ".join(f'<a href="#{quote(name)}">{escape(name)}</a>' for name in names)
    return f', <span class="error">{len(names)} failed:</span> {links}' if names else ""


def _card(name: str, entry: dict[str, Any], album: _Album) -> str:
    title = escape(entry["title"] or Path(entry["scene"]).stem)
    report = entry.get("report")
    shown = album.shown(report, title) if report else '<div class="nothing">no result</div>'
    values = "".join(_row(key, str(value), "value") for key, value in entry["values"].items())
    error = f'<p class="error">{escape(entry["error"])}</p>' if "error" in entry else ""
    facts = "".join(_row(*fact) for fact in _facts(report)) + _files(report["files"]) if report else ""
    return f"""<article class="{entry["status"]}" id="{escape(name)}">
{shown}
<div class="about"><h2>{title}</h2><p class="job">{escape(name)} · {escape(entry["scene"])}</p>{error}
<table>{values}{facts}</table></div>
</article>"""


def _row(key: str, value: str, kind: str = "fact") -> str:
    return f'<tr class="{kind}"><td>{escape(key)}</td><td>{escape(value)}</td></tr>'


def _files(files: list[str]) -> str:
    links = ", ".join(f'<a href="{quote(file)}">{escape(Path(file).name)}</a>' for file in files)
    return f'<tr class="fact"><td>files</td><td>{links}</td></tr>'


def _facts(report: dict[str, Any]) -> list[tuple[str, str]]:
    phases = report["phases"]
    deaths = sum(sum(causes.values()) for causes in report["deaths"].values())
    born = sum(report["births"].values())
    facts = [
        ("length", f"{report['duration']:g} s, {report['frames']} frames"),
        ("particles", f"{born:,} born, {deaths:,} died, {report['alive']:,} at the end"),
        ("time", f"{phases['wall_s']:.1f} s, {phases['simulate_s']:.1f} s of it simulating"),
        ("pace", f"{report['particle_steps_per_second'] / 1e6:,.3g} million particle-steps a second"),
    ]
    for group, error in report.get("estimated_error", {}).items():
        pixels = "" if error["pixels"] is None else f", {error['pixels']['p95']:.2g} px"
        facts.append((f"error of {group}", f"{error['metres']['p95']:.2g} m{pixels} ({error['trend']})"))
    if report.get("not_estimated"):
        facts.append(("error not estimated", ", ".join(report["not_estimated"])))
    return facts
