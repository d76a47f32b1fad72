"""Makes docs/images/studio.png: the screen Tracks on a simulated walk whose tracker erred.

Needs Chromium, Playwright and the built page (`python3 dev.py studio`).
"""

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]

from support.studio_page import Studio, browser, served, walked, window  # noqa: E402

SIZE = (1600, 900)


def main() -> None:
    """Simulate, look at the first problem, and keep the picture."""
    with (
        tempfile.TemporaryDirectory() as folder,
        browser() as running,
        served(walked(Path(folder)), "--faults") as server,
    ):
        studio = Studio(window(running, *SIZE), server).enter(server.address).open()
        studio.press("n")
        studio.idle().page.wait_for_timeout(3000)
        studio.page.screenshot(path=str(ROOT / "docs" / "images" / "studio.png"))


if __name__ == "__main__":
    main()
