"""What is told of the studio where a test of its page fails: what the page shows and waits for, what its server does.

A server that hangs is asked for the stacks of its threads by a signal, which needs no thread of it to answer.
"""

import faulthandler
import os
import signal
import time
from contextlib import contextmanager
from pathlib import Path

STACKS_S = 5.0
"""s within which a server that lives has written its stacks."""
LOOK_MS = 3000
"""ms within which a page that lives says what it shows."""
BY_SIGNAL = hasattr(faulthandler, "register")
RUNNING = []
"""The servers that are there now; each with its pages."""


class Requests:
    """Those of a page: without an answer yet, and lost."""

    def __init__(self, page):
        self.open, self.lost = {}, []
        page.on("request", lambda request: self.open.update({request: request.url}))
        page.on("requestfinished", lambda request: self.open.pop(request, None))
        page.on("requestfailed", self._failed)

    def _failed(self, request):
        self.open.pop(request, None)
        self.lost.append(f"{request.url} ({request.failure})")


def write_stacks_when_asked(file):
    """In the server's own process."""
    if BY_SIGNAL:
        faulthandler.register(signal.SIGUSR1, Path(file).open("w"), all_threads=True)  # noqa: SIM115  while it lives


def stacks(process, file):
    """What the threads of a server's process do."""
    if not process.is_alive():
        return f"the server has ended with exit code {process.exitcode}"
    if not BY_SIGNAL:
        return "the server lives"
    before, end = _text(file), time.monotonic() + STACKS_S
    os.kill(process.pid, signal.SIGUSR1)
    while _text(file) == before and time.monotonic() < end:
        time.sleep(0.05)
    return "the server lives, and its threads are at\n" + _text(file)[len(before) :]


def _text(file):
    return file.read_text("utf-8") if file.is_file() else ""


def shown(studio):
    """What a page shows in words, and what it was told and not told."""
    try:
        words = studio.page.locator("body").inner_text(timeout=LOOK_MS)
    except Exception as error:
        words = f"nothing: {error}"
    said = [f"{studio.page.url} shows", words, f"errors {studio.errors}"]
    return "\n".join([*said, f"lost {studio.requests.lost}", f"without an answer {[*studio.requests.open.values()]}"])


def seen():
    """Of all servers that are there, in one text."""
    return "\n\n".join(
        "\n".join([*(shown(page) for page in server.pages if not page.page.is_closed()), server.stacks()])
        for server in RUNNING
    )


@contextmanager
def told():
    """What is seen goes with an error, as the server will have gone when that is reported."""
    try:
        yield
    except Exception as error:
        error.add_note(seen())
        raise
