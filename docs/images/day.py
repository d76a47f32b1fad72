"""Makes the pictures of the operator's manual, docs/images/day/*.webp: one day in the studio, on simulated recordings.

Needs Chromium, Playwright and the built page (`python3 dev.py studio`). `python docs/images/day.py morning` makes those
of the morning alone.
"""

from __future__ import annotations

import csv
import re
import sys
import tempfile
from base64 import b64decode
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tests")]

from kinemark.data import MarkerTrajectory, Trajectories, Trial  # noqa: E402
from kinemark.engine.simulate import Scene, simulate  # noqa: E402
from kinemark.io.trial import write_trial  # noqa: E402
from kinemark.synth.arm import arm  # noqa: E402
from support.studio_page import Studio, browser, served, walked, window  # noqa: E402

PICTURES = ROOT / "docs" / "images" / "day"
MOST_BYTES = 100_000
"""Of a picture; the quality below is lowered until it holds."""
SETTLED_MS = 1500


def picture(studio: Studio, name: str) -> None:
    """Keep what is shown, as small as it may be."""
    studio.idle().page.mouse.move(1365, 300)  # over nothing
    studio.page.wait_for_timeout(SETTLED_MS)
    wire = studio.page.context.new_cdp_session(studio.page)
    for quality in (80, 65, 50, 35):
        shot = b64decode(wire.send("Page.captureScreenshot", {"format": "webp", "quality": quality})["data"])
        if len(shot) <= MOST_BYTES:
            break
    (PICTURES / f"{name}.webp").write_bytes(shot)
    print(f"{name}  {len(shot) / 1000:.0f} kB at {quality}")


def day(running: Any, folder: Path, work: Callable[[Studio], None], *options: str) -> None:
    """Open the studio on a folder, and work."""
    with served(folder, *options) as server:
        context = window(running)
        studio = Studio(context, server)
        studio.asked = "?still=1&theme=light"
        work(studio.enter(server.address))
        context.close()


def morning(running: Any, base: Path) -> None:
    """A session of recordings, calibrated and run; control balls that are pointed at."""
    monday = base / "laboratory" / "monday"
    simulate(monday, scene=Scene(seconds=1.0, size_px=(488, 378), focal_px=500.0, noise=1.0, cameras=5))
    (monday / "session.toml").unlink()
    day(running, monday.parent, _new_session)
    box = base / "arm"
    simulate(box, scene=Scene(seconds=0.4, size_px=(376, 292), focal_px=385.0, cameras=3, motion="feeding", barrel=0.0))
    (box / "session.toml").unlink()
    rows = list(csv.DictReader((box / "points.csv").read_text("utf-8").splitlines()))
    with (box / "points.csv").open(
        "w", newline="", encoding="utf-8"
    ) as file:  # where they are, not yet where they are seen
        writer = csv.DictWriter(file, ["name", "x_mm", "y_mm", "z_mm"], extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    day(running, box, _balls)


def _new_session(studio: Studio) -> None:
    page = studio.page
    page.get_by_role("button", name="New session …").click()
    page.get_by_role("button", name=re.compile("monday")).click()
    page.get_by_role("button", name="Make it and run").wait_for()
    picture(studio, "new-session")
    page.get_by_role("button", name="Make it, then calibrate").click()
    page.get_by_role("heading", name="Cameras & calibration").wait_for()
    studio.idle().press("Shift+Enter")
    page.locator("[data-grade]").wait_for()
    picture(studio, "cameras")
    page.get_by_role("button", name="Home", exact=True).click()
    page.get_by_role("button", name="Run walk01", description="Run").click()
    page.get_by_text("done", exact=True).wait_for()
    picture(studio, "home")


def _balls(studio: Studio) -> None:
    page = studio.page
    page.get_by_role("button", name="New session …").click()
    page.get_by_role("button", name=re.compile("arm")).click()
    page.get_by_role("button", name="Make it, then calibrate").click()
    page.locator("canvas[data-camera=cam1]").wait_for()
    page.get_by_text(re.compile(r"^\d+ markers$")).wait_for()
    picture(studio, "balls")


def noon(running: Any, base: Path) -> None:
    """Images, and what is probably wrong."""
    day(running, walked(base), _noon, "--faults")


def _noon(studio: Studio) -> None:
    page = studio.open("detect").page
    page.locator("[data-found=yes]").wait_for()
    canvas = page.get_by_role("region", name="cam3").locator("canvas").bounding_box()
    page.mouse.click(canvas["x"] + 0.6 * canvas["width"], canvas["y"] + 0.62 * canvas["height"])
    picture(studio, "detect")
    page.get_by_role("button", name=re.compile("^Tracks")).click()
    studio.idle().press("n")
    picture(studio, "tracks")
    studio.press("F1")
    page.keyboard.type("swap")
    picture(studio, "help")


def afternoon(running: Any, base: Path) -> None:
    """Names, gaps, the report, and angles of an arm that feeds."""
    day(running, walked(base), _afternoon, "--faults")
    subject = arm(duration_s=3.0, seed=2)
    paths = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(subject.names, subject.xyz, strict=True))
    (base / "files").mkdir(exist_ok=True)
    write_trial(Trial("feeding", Trajectories(paths, 50.0)), base / "files" / "feeding.c3d")
    day(running, base / "files", _angles)


def _afternoon(studio: Studio) -> None:
    studio.open("labels")
    picture(studio, "labels")
    studio.page.get_by_role("button", name=re.compile("^Gaps")).click()
    studio.page.locator("main[data-screen=gaps]").wait_for()
    studio.idle().press("n")
    studio.page.get_by_role("button", name=re.compile("^Fill by")).wait_for()
    picture(studio, "gaps")
    studio.page.get_by_role("button", name=re.compile("^Report")).click()
    studio.page.frame_locator("iframe").get_by_role("heading", name="walk01").wait_for()
    picture(studio, "report")


def _angles(studio: Studio) -> None:
    studio.open("angles", "feeding.c3d")
    studio.page.locator("[data-angle]").first.wait_for()
    studio.press(*["Shift+ArrowRight"] * 6)
    picture(studio, "angles")


PARTS = {"morning": morning, "noon": noon, "afternoon": afternoon}


def main(*parts: str) -> None:
    """Make those of all parts of the day, or of those that are named."""
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as base, browser() as running:
        for name in parts or PARTS:
            PARTS[name](running, Path(base))


if __name__ == "__main__":
    main(*sys.argv[1:])
