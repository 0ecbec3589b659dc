from __future__ import annotations

import sys

import pytest

from particlecli.cli.progress import progress
from particlecli.run import Progress


def test_lines_come_now_and_then_and_tell_the_time_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = 100.0
    monkeypatch.setattr("time.monotonic", lambda: now)
    with progress(quiet=False) as show:
        assert show is not None
        for frame in range(1, 22):
            show(Progress(frame, 41, 1234))
            now += 1.0
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.splitlines() == [
        "frame 6 of 41, 1,234 particles, 35 s left",
        "frame 11 of 41, 1,234 particles, 30 s left",
        "frame 16 of 41, 1,234 particles, 25 s left",
        "frame 21 of 41, 1,234 particles, 20 s left",
    ]


def test_lines_name_what_is_no_run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    clock = iter([0.0, 7.0])
    monkeypatch.setattr("time.monotonic", lambda: next(clock))
    with progress(quiet=False, what="SciPy at") as show:
        assert show is not None
        for frame in (1, 2):
            show(Progress(frame, 3, 5))
    assert capsys.readouterr().err == "SciPy at frame 2 of 3, 5 particles, 7 s left\n"


def test_quiet_shows_nothing() -> None:
    with progress(quiet=True) as show:
        assert show is None


def test_terminal_gets_a_bar(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    with progress(quiet=False) as show:
        assert show is not None
        show(Progress(3, 41, 1234))
    output = capsys.readouterr()
    assert output.out == ""
    assert "3/41" in output.err
    assert "1,234 particles" in output.err
