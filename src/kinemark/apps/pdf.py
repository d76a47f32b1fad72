"""Pages on paper: a page that Kinemark wrote, printed to a PDF by a browser of the Chromium family that is installed.

A browser draws what the page draws, so that a report and its PDF show the same. It runs without a window, a profile or
a network. Pages say themselves how they are printed (`@page` and `@media print` of their templates): A4, light, all
drawn.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from ..data import KinemarkError

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge", "microsoft-edge")
PLACES = {
    "darwin": (
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "/Applications/Chromium.app/Contents/MacOS/Chromium",
        "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    ),
    "win32": (
        r"C:\Program Files\Google\Chrome\Application\chrome.exe",
        r"C:\Program Files (x86)\Google\Chrome\Application\chrome.exe",
        r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
    ),
}
"""Where browsers lie that are not on the path."""
PAGES = (".html", ".htm")
"""Endings of pages."""
OPTIONS = (
    "--headless", "--disable-gpu", "--no-first-run", "--disable-sync", "--disable-extensions", "--disable-quic",
    "--disable-background-networking", "--disable-component-update", "--host-resolver-rules=MAP * ~NOTFOUND",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-pdf-header-footer", "--virtual-time-budget=60000",
)  # fmt: skip
"""No network; drawings in space without a graphics card; 60 s of the page's own time, passed as fast as it draws."""
PATIENCE_S = 300.0
"""s after which a browser that has not printed is given up; chosen: a report of 100 drawings takes 20 s."""


def find_browser() -> Path | None:
    """The first browser that can print; KINEMARK_BROWSER names another one, or none where it is empty."""
    said = os.environ.get("KINEMARK_BROWSER")
    if said is not None:
        return Path(said) if said and Path(said).is_file() else None
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    places = (Path(place) for place in PLACES.get(sys.platform, ()))
    return Path(found) if found else next((place for place in places if place.is_file()), None)


def print_pdf(page: Path, target: Path) -> Path:
    """Print a page of HTML to `target`, a PDF of A4 pages; gives it.

    Raises:
        KinemarkError: there is no such page, no browser, or the browser printed nothing.
    """
    if not page.is_file():
        raise KinemarkError(f"There is no page {page}. Run the trial first, or give the page that is to be printed.")
    if page.suffix.lower() not in PAGES:
        raise KinemarkError(f"{page} is no page. Give a report, as report.html, or a folder of results.")
    browser = find_browser()
    if browser is None:
        raise KinemarkError(
            "A PDF is printed by a browser, and neither Chromium, Chrome nor Edge was found. Install one, or name it "
            "by KINEMARK_BROWSER=/path/to/it; or open the page in another browser and print it to a file there."
        )
    with tempfile.TemporaryDirectory(prefix="kinemark-pdf-", ignore_cleanup_errors=True) as folder:
        printed = Path(folder, "page.pdf")
        said = _run(browser, page, printed, Path(folder, "profile"))
        if not printed.is_file() or not printed.read_bytes().startswith(b"%PDF-"):
            raise KinemarkError(f"{browser.name} printed nothing of {page}: {said or 'it said nothing'}.")
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(printed, target)
    return target


def _run(browser: Path, page: Path, printed: Path, profile: Path) -> str:
    """Print; gives the last line that the browser said."""
    alone = ("--no-sandbox",) if sys.platform == "linux" and os.geteuid() == 0 else ()  # its sandbox needs a user
    own = (f"--user-data-dir={profile}", f"--print-to-pdf={printed}", page.resolve().as_uri())
    try:
        done = subprocess.run(
            [str(browser), *OPTIONS, *alone, *own], check=False, capture_output=True, timeout=PATIENCE_S
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    return done.stderr.decode(errors="replace").strip().rsplit("\n", 1)[-1]
