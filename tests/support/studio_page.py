"""The studio in a browser: a session that was simulated and run, its server, and a page in Chromium by Playwright."""

import json
import os
import re
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest
from filelock import FileLock

from support.browser import chromium
from support.effort import EFFORT
from support.studio_seen import RUNNING, Requests, stacks, told
from support.studio_server import process_of

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "src" / "kinemark" / "apps" / "studio" / "page" / "index.html"
AXE = ROOT / "ui" / "node_modules" / "axe-core" / "axe.min.js"
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run", "--disable-sync",
         "--disable-background-networking", "--disable-component-update", "--disable-gpu-rasterization",
         "--disable-gpu-compositing"]  # fmt: skip
"""Only what is drawn by WebGL goes through an emulated graphics card: pages through it cost three times as much."""
PATIENCE_MS = 60_000  # a busy machine draws slowly


def needed():
    """Skip where something is not here."""
    for module in ("playwright", "fastapi", "uvicorn"):
        pytest.importorskip(module, reason=f"needs {module}")
    if not PAGE.is_file():
        pytest.skip("the page of the studio is not built: python3 dev.py studio")
    return chromium()


def walked(shared):
    """The folder of a session: a walk of 15 markers before 5 cameras, rendered and run; made once for all processes.

    Every image says the number of its frame.
    """
    from kinemark.engine.session import Session
    from kinemark.engine.simulate import Scene, simulate
    from support.numbered_session import burn

    folder = shared / "walk"
    with FileLock(shared / "walk.lock"):
        if not (folder / "results").is_dir():
            scene = Scene(cameras=5, seconds=2.4, focal_px=500.0, size_px=(488, 378), noise=1.0)
            simulate(folder, scene=scene)
            burn(folder)
            Session.open(folder).run()
    return folder


def entry():
    """The script that the page names."""
    return PAGE.parent / re.search(r'<script[^>]* src="/([^"]+)"', PAGE.read_text("utf-8")).group(1)


def parts_of(script):
    """A built script and all that it imports before it runs; what it may import later is not among it."""
    found, left = set(), [script]
    while left:
        path = left.pop()
        if path not in found:
            found.add(path)
            named = re.findall(r'(?:from|import)\s*"\./([^"]+\.js)"', path.read_text("utf-8"))
            left += [path.parent / name for name in named]
    return found


def needed_by(screen):
    """The scripts that a browser has read when it shows a screen that it was opened on."""
    (own,) = entry().parent.glob(f"{screen}-*.js")
    return parts_of(entry()) | parts_of(own)


def copied(folder, target):
    """A session of a test's own; recordings, which nobody changes, are the same files."""
    shutil.copytree(folder, target, copy_function=lambda a, b: _link(Path(a), Path(b)))
    return target


def _link(a, b):
    if a.suffix in (".mkv", ".png"):
        os.link(a, b)
    else:
        shutil.copy2(a, b)


class Server:
    """The server of a folder; `address` opens it once, `base` is without its token. `pages` are those that it gave."""

    def __init__(self, folder, *options):
        self.folder, self.options, self.pages = folder, options, []
        self.own = tempfile.TemporaryDirectory(prefix="kinemark-stacks-")
        self.start()

    def start(self, *more):
        self.process, self.said = process_of(self.folder, self._file, *self.options, *more)
        RUNNING.append(self)
        self.address = self.next_address()
        self.base = self.address.split("?")[0]

    @property
    def _file(self):
        return Path(self.own.name) / "stacks.txt"

    def stacks(self):
        """What its threads do now."""
        return stacks(self.process, self._file)

    def next_address(self):
        """An address for another browser: each works once, and the server then says the next."""
        return re.search(r"http://\S+", self.said.recv()).group()

    def kill(self):
        self.process.kill()
        self.process.join()
        self.said.close()
        if self in RUNNING:
            RUNNING.remove(self)


@contextmanager
def served(folder, *options):
    """A server that ends with the test."""
    server = Server(folder, *options)
    try:
        with told():
            yield server
    finally:
        server.kill()
        server.own.cleanup()


@contextmanager
def browser():
    """Chromium."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
        try:
            yield running
        finally:
            running.close()


class Studio:
    """A page of the studio: what a person sees of it, and the keys that they press. `errors` are the console's."""

    def __init__(self, context, server, *, theme="light", still=True):
        self.page, self.server, self.errors = context.new_page(), server, []
        self.page.set_default_timeout(PATIENCE_MS)
        EFFORT.watch(self.page)
        self.requests = Requests(self.page)
        server.pages.append(self)
        self.asked = f"?aa=0&theme={theme}{'&still=1' if still else ''}"
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._said)

    def _said(self, said):
        if said.type == "error":
            self.errors.append(f"{said.text} {said.location['url']}")

    def enter(self, address):
        """By the address of the terminal, then as tests want it."""
        self.page.goto(address)
        self.page.goto(self.server.base + self.asked)
        return self

    def open(self, screen="tracks", trial="walk01"):
        """A trial by its name on Home, and one of its screens by the rail."""
        self.page.get_by_role("button", name=trial, exact=True).click()
        self.page.get_by_role("region", name="Three dimensions").or_(
            self.page.locator("[data-screen=tracks] canvas")
        ).first.wait_for()
        self.page.get_by_text("Errors expected").first.wait_for()
        if screen != "tracks":
            self.page.get_by_role("button", name=re.compile(f"^{screen.title()}")).click()
            self.page.locator(f"main[data-screen={screen}]").wait_for()
        return self.idle()

    def idle(self):
        """Until nothing is asked of the server any more."""
        self.page.locator("main[data-busy=no]").wait_for()
        return self

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)
        return self

    @property
    def head(self):
        return self.page.locator("main").get_attribute("data-head")

    def acted(self, before):
        """Until an act has changed the head."""
        self.page.locator(f"main:not([data-head='{before}'])[data-busy=no]").wait_for()
        return self

    def ran(self):
        """Until a run that was asked for is over, and the trial is there again."""
        self.page.locator("main[data-stale=no][data-busy=no]").wait_for()
        return self

    def note(self):
        return self.page.locator("footer [role=status]").inner_text()


def window(running, width=1366, height=768, **options):
    """A browser's window."""
    return running.new_context(viewport={"width": width, "height": height}, **options)


def by_another_program(folder, trial="walk01"):
    """A session as another copy of Kinemark left it: its results have keys that are not ours."""
    file = folder / "results" / trial / "steps.json"
    steps = json.loads(file.read_text("utf-8"))
    for step in steps:
        step["version"], step["input"] = "0.0.9+0123456789abcdef", "0" * 16
    file.write_text(json.dumps(steps), "utf-8")
    return folder
