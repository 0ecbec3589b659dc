import signal

import pytest

from particlecli import interruption
from particlecli.interruption import Interrupted, heed, stop_on


@pytest.fixture
def usr1(monkeypatch: pytest.MonkeyPatch):
    """A signal that stops, for the time of a test."""
    monkeypatch.setattr(interruption, "_came", None)
    before = signal.signal(signal.SIGUSR1, signal.SIG_DFL)
    yield signal.SIGUSR1
    signal.signal(signal.SIGUSR1, before)


def test_a_signal_whose_exception_is_swallowed_is_heeded_later(usr1: signal.Signals) -> None:
    stop_on(usr1)
    heed()
    with pytest.raises(Interrupted):
        signal.raise_signal(usr1)
    with pytest.raises(Interrupted) as stopped:
        heed()
    assert stopped.value.signal == usr1


def test_what_is_ignored_stays_ignored(usr1: signal.Signals) -> None:
    signal.signal(usr1, signal.SIG_IGN)
    stop_on(usr1)
    signal.raise_signal(usr1)
    heed()
