"""The page of a batch, also as a browser sees it."""

from __future__ import annotations

import re
import shutil
from html import escape
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from particlecli.batch import page as page_module
from particlecli.batch.page import page
from tests.batch.browser import CHROMIUM, browser
from tests.batch.conftest import report

PROBE = """
new Promise(loaded => document.readyState == "complete" ? loaded() : window.addEventListener("load", loaded))
.then(async () => {
  const images = [...document.images].filter(image => image.complete && image.naturalWidth > 0).length;
  const posters = [...document.querySelectorAll("video")].map(video => new Promise(done => {
    const image = new Image();
    image.onload = () => done(image.naturalWidth); image.onerror = () => done(0); image.src = video.poster;
  }));
  const videos = [...document.querySelectorAll("video")].map(video => new Promise(done => {
    video.onloadeddata = () => done(video.videoWidth); video.onerror = () => done(0);
    video.preload = "auto"; video.load();
  }));
  return [images, ...await Promise.all([...posters, ...videos])];
})
"""


def entry(**facts: object) -> dict[str, object]:
    return {"title": "Balls", "scene": "balls.yaml", "values": {}, "status": "done", **facts}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two videos of a second, and a folder with a picture."""
    writer = imageio_ffmpeg.write_frames(str(tmp_path / "a b.mp4"), (64, 48), fps=10, macro_block_size=1)
    writer.send(None)
    for index in range(10):
        writer.send(np.full((48, 64, 3), 20 * index, np.uint8).tobytes())
    writer.close()
    shutil.copy(tmp_path / "a b.mp4", tmp_path / "c.mp4")
    (tmp_path / "frames").mkdir()
    Image.new("RGB", (64, 48), "#804020").save(tmp_path / "frames" / "frame_00000.png")
    return tmp_path


def test_values_facts_errors_and_links_are_there(folder: Path) -> None:
    text = page("All", {
        "balls,dt=1": entry(values={"integrator.dt": "0.01"}, report=report("a b.mp4", "balls.rrd")),
        "worse": entry(title='<b>"worse"</b>', status="failed", error="x < y & z"),
    }, folder)  # fmt: skip
    assert '2 runs, <span class="error">1 failed:</span> <a href="#worse">worse</a>' in text
    assert "<td>integrator.dt</td><td>0.01</td>" in text
    assert "3 born, 1 died, 2 at the end" in text
    assert "0.01 m, 0.3 px (converging)" in text
    assert '<a href="balls.rrd">' in text
    assert escape('<b>"worse"</b>') in text
    assert "x &lt; y &amp; z" in text
    assert "<b>" not in text


def test_nothing_is_loaded_from_elsewhere(folder: Path) -> None:
    text = page("All", {"a": entry(report=report("a b.mp4")), "b": entry(report=report("frames"))}, folder)
    sources = re.findall(r'(?:src|poster)="([^"]*)"', text)
    assert len(sources) == 3
    assert all(source.startswith("data:") for source in sources)
    assert not re.search(r"https?:|<link|@import|<script", text)


def test_many_large_videos_stay_beside_the_page(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_module, "EMBEDDED_BYTES", (folder / "c.mp4").stat().st_size)
    text = page("All", {"c": entry(report=report("c.mp4")), "a": entry(report=report("a b.mp4"))}, folder)
    videos = re.findall(r'<video[^>]* src="([^"]{0,9})', text)
    assert videos == ["data:vide", "a%20b.mp4"]


def test_runs_without_pictures_say_so(folder: Path) -> None:
    assert "no pictures" in page("All", {"a": entry(report=report("balls.npz"))}, folder)
    assert "no result" in page("All", {"a": entry(status="waiting")}, folder)


@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")
def test_a_browser_shows_it_from_disk(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_module, "EMBEDDED_BYTES", (folder / "c.mp4").stat().st_size)
    entries = {name: entry(report=report(file)) for name, file in (("c", "c.mp4"), ("a", "a b.mp4"), ("f", "frames"))}
    (folder / "index.html").write_text(page("All", entries, folder))
    with browser(folder / "profile") as chromium:
        assert chromium.evaluate(folder / "index.html", PROBE) == [1, 480, 480, 64, 64]
