"""A page in Chromium, without a network: what it measures, what it complains of, how it looks.

Chromium is driven over its debugging pipe, so nothing but the browser itself is needed. Tests that ask for a browser
are skipped where there is none.
"""

import json
import os
import shutil
import subprocess
import tempfile
import time
from base64 import b64decode
from contextlib import contextmanager

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
OPTIONS = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run",
           "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-pipe")  # fmt: skip
PATIENCE_S = 120  # a busy machine starts a browser slowly


def chromium():
    """Path of the browser; skips the test where there is none."""
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"needs a browser: none of {', '.join(NAMES)} is installed")
    return found


class Page:
    """A tab of a size in CSS px; `errors` are what the console was told."""

    def __init__(self, send, width, height, *, dark=False):
        self._send, self.errors = send, []
        self.send("Page.enable")
        self.send("Runtime.enable")
        self.send("Log.enable")
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.send("Emulation.setDeviceMetricsOverride", **size)
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.send("Emulation.setEmulatedMedia", features=scheme)

    def send(self, method, **parameters):
        """The answer to a command; events on the way are looked at for errors."""
        return self._send(method, parameters, self._heard)

    def _heard(self, event):
        values = event.get("params", {})
        if event["method"] == "Runtime.exceptionThrown":
            self.errors.append(values["exceptionDetails"].get("exception", {}).get("description", "exception"))
        if event["method"] == "Log.entryAdded" and values["entry"]["level"] == "error":
            self.errors.append(values["entry"]["text"])

    def open(self, path, *, drawn=True):
        """Load a file, and wait until it is there, with its drawings unless `drawn` is false."""
        self.send("Page.navigate", url=path.resolve().as_uri())
        self.until("location.protocol === 'file:' && document.readyState === 'complete'")
        if drawn:
            self.until("!document.getElementById('library') || document.documentElement.dataset.drawn")

    def ask(self, expression):
        """The value of an expression of JavaScript; promises are waited for."""
        told = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in told, told["exceptionDetails"]
        return told["result"].get("value")

    def until(self, expression):
        """Wait until an expression holds."""
        end = time.monotonic() + PATIENCE_S
        while not self.ask(expression):
            assert time.monotonic() < end, f"never came true: {expression}"
            time.sleep(0.05)

    def picture(self, path, *, whole=True):
        """A screenshot, of the whole page or of what is in the window."""
        shot = self.send("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(b64decode(shot["data"]))


@contextmanager
def opened(path, *, width=1366, height=768, dark=False, drawn=True):
    """A file in a tab of this size."""
    (read, write), (answers, told) = os.pipe(), os.pipe()
    profile = tempfile.mkdtemp(prefix="kinemark-browser-")

    def wire():
        os.dup2(read, 103)
        os.dup2(told, 104)
        os.dup2(103, 3)
        os.dup2(104, 4)

    browser = subprocess.Popen(
        [chromium(), *OPTIONS, f"--user-data-dir={profile}"], preexec_fn=wire, close_fds=False,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(read)
    os.close(told)
    try:
        talk = _Pipe(write, answers)
        target = talk("Target.createTarget", {"url": "about:blank"}, lambda event: None)["targetId"]
        session = talk("Target.attachToTarget", {"targetId": target, "flatten": True}, lambda event: None)
        page = Page(talk.of(session["sessionId"]), width, height, dark=dark)
        page.open(path, drawn=drawn)
        yield page
    finally:
        browser.kill()
        browser.wait()
        os.close(write)
        os.close(answers)
        shutil.rmtree(profile, ignore_errors=True)


class _Pipe:
    """Commands to the browser, each followed by a zero byte, and what comes back."""

    def __init__(self, write, read, session=None):
        self.write, self.read, self.session, self.rest, self.number = write, read, session, b"", 0

    def of(self, session):
        self.session = session
        return self

    def __call__(self, method, parameters, heard):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return answer["result"]
            if "method" in answer:
                heard(answer)

    def _next(self):
        while b"\0" not in self.rest:
            part = os.read(self.read, 1 << 20)
            assert part, "the browser has gone"
            self.rest += part
        message, _, self.rest = self.rest.partition(b"\0")
        return json.loads(message)
