"""Headless Chromium, asked over its debugging pipe: what a page's script finds, however long that takes."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

AS_FILES_3_AND_4 = """
import fcntl, os, sys
read, write = (fcntl.fcntl(int(file), fcntl.F_DUPFD, 10) for file in sys.argv[1:3])
os.dup2(read, 3)
os.dup2(write, 4)
os.execv(sys.argv[3], sys.argv[3:])
"""


class Browser:
    """A running Chromium that takes DevTools commands, each closed by a zero byte."""

    def __init__(self, requests: int, answers: int) -> None:
        self._requests, self._answers = os.fdopen(requests, "wb"), os.fdopen(answers, "rb")
        self._count, self._rest = 0, b""

    def ask(self, method: str, session: str | None = None, **parameters: object) -> dict[str, object]:
        """The result of one command; events that come before it are passed over."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        self._requests.write(json.dumps(message | ({"sessionId": session} if session else {})).encode() + b"\0")
        self._requests.flush()
        while (answer := self._next()).get("id") != self._count:
            pass
        assert "error" not in answer, answer
        result: dict[str, object] = answer["result"]
        return result

    def evaluate(self, page: Path, script: str) -> object:
        """What the promise of a script comes to on a page opened from disk."""
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        session = str(self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"])
        self.ask(
            "Page.navigate", session, url=page.as_uri()
        )  # answered when the page has taken the place of the blank one
        answer = self.ask("Runtime.evaluate", session, expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"]["value"]  # type: ignore[index]

    def _next(self) -> dict[str, object]:
        while b"\0" not in self._rest:
            part = self._answers.read1()
            assert part, "the browser closed its pipe"
            self._rest += part
        message, self._rest = self._rest.split(b"\0", 1)
        answer: dict[str, object] = json.loads(message)
        return answer


@contextmanager
def browser(profile: Path) -> Iterator[Browser]:
    """Chromium without a screen or a network, closed at the end."""
    (read, requests), (answers, write) = os.pipe(), os.pipe()
    command = [
        sys.executable, "-c", AS_FILES_3_AND_4, str(read), str(write), str(CHROMIUM), "--headless", "--no-sandbox",
        "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update",
        "--disable-sync", "--autoplay-policy=no-user-gesture-required", "--remote-debugging-pipe",
        f"--user-data-dir={profile}",
    ]  # fmt: skip
    process = subprocess.Popen(command, pass_fds=(read, write), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(read)
    os.close(write)
    try:
        yield Browser(requests, answers)
    finally:
        process.kill()
        process.wait()
