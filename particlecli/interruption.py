"""Signals that ask a process to stop. They are not lost where their exception is.

Python raises an exception where a signal finds it. While Taichi traces kernels, that may be inside a clause of its own
that swallows any exception; so the signal is remembered, and whoever loops over frames asks for it.
"""

from __future__ import annotations

import signal
from typing import NoReturn

_came: int | None = None


class Interrupted(KeyboardInterrupt):
    """A signal asked to stop.

    Attributes:
        signal: its number.
    """

    def __init__(self, number: int) -> None:
        super().__init__()
        self.signal = number


def stop_on(*numbers: int) -> None:
    """Make signals raise `Interrupted`, once where they come and at every `heed` from then on.

    What the process was told to ignore it goes on ignoring, as work in the background of a shell script does.
    """
    for number in numbers:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)


def heed() -> None:
    """Stop if a signal has asked for it.

    Raises:
        Interrupted: it has.
    """
    if _came is not None:
        raise Interrupted(_came)


def _stop(number: int, _: object) -> NoReturn:
    global _came
    _came = number
    raise Interrupted(number)
