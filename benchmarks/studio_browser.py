"""How soon the studio shows what is asked for, in Chromium by Playwright: the bars of a screen one likes to work on.

    python benchmarks/studio_browser.py [--long] [--images N]

- a file of 60 markers in 10 000 frames (with --long also 100 000): from the click on Home to its first picture; script
  a frame while scrubbing; from the key to the picture of an edit and of its undoing; memory of the page's process
- eight cameras: from the key to the right images, at once after a trial was opened for the first time and in one that
  was looked at before; and N random frames whose burnt-in number is read from the screen

Times are of this machine and its load, software rendering included; what is measured is wall time in the page, script
by the browser's own account. Nothing is measured where there is no Chromium.
"""

from __future__ import annotations

import argparse
import re
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from metrics import Metric

sys.path.append(str(Path(__file__).parents[1] / "tests"))

from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.io.trial import write_trial

MARKERS, FRAMES, LONG = 60, 10_000, 100_000
CAMERAS, SIZE, SECONDS, RATE = 8, (752, 582), 1.0, 50.0
SCRUBBED, EDITS, KEYS, SEEKS = 200, 30, 40, 1000
WATCH = """
() => {
  const main = document.querySelector("main"), times = window.times = [];
  let pressed = 0;
  const note = () => times.push(performance.now() - pressed);
  const drawn = () => WHERE.getAttribute("WHAT") && requestAnimationFrame(() => setTimeout(note, 0));
  addEventListener("keydown", () => { pressed = performance.now(); }, true);
  new MutationObserver(drawn).observe(WHERE, { attributes: true, attributeFilter: ["WHAT"] });
}
"""
"""ms from a key to the picture after an attribute has changed."""
WORK = """
() => {
  const began = performance.now(), all = Float64Array.from({ length: 400000 }, (_, i) => (i * 7919) % 400009);
  for (let k = 0; k < 5; k++) all.slice().sort();
  return performance.now() - began;
}
"""
"""ms of a fixed piece of work in the page, to which metrics are ratios."""


class Bar(NamedTuple):
    """What is measured, its unit, and the most that it should be on a quiet machine."""

    name: str
    unit: str
    most: float


BARS = (
    Bar("open 60 x 10 000", "ms", 800.0),
    Bar("script of a scrubbed frame", "ms", 4.0),
    Bar("edit or undo to picture, 95 %", "ms", 50.0),
    Bar("memory of the page", "MB", 400.0),
    Bar("memory of the page, eight cameras", "MB", 400.0),
    Bar("eight cameras, key to images, 95 %", "ms", 120.0),
    Bar("eight cameras, at once after the first opening, 95 %", "ms", 120.0),
    Bar("wrong images of random frames", "images", 0.0),
    Bar("open 60 x 100 000", "ms", 4000.0),
)


def write_file(folder: Path, frames: int, markers: int = MARKERS) -> Path:
    """A C3D of markers that swing; every tenth has a gap."""
    rng, t = np.random.default_rng(0), np.arange(frames) / 100.0
    phase, centre = rng.uniform(0, 6, (markers, 1, 3)), rng.uniform(-800, 800, (markers, 1, 3))
    xyz = centre + 100 * np.sin(2 * t[None, :, None] + phase[:, None][..., 0, :])
    for path, first in zip(xyz[::10], rng.integers(1, frames - 60, markers), strict=False):
        path[first : first + 40] = np.nan
    paths = tuple(MarkerTrajectory.measured(f"M{m:02d}", path) for m, path in enumerate(xyz))
    file = folder / f"t{frames}.c3d"
    write_trial(Trial(file.stem, Trajectories(paths, 100.0)), file)
    return file


@contextmanager
def page_of(folder: Path) -> Iterator[Any]:
    """The studio's Home in a window of 1366 × 768 px."""
    from support.studio_page import Studio, browser, served, window

    with browser() as running, served(folder) as server:
        context = window(running, bypass_csp=True)
        yield Studio(context, server).enter(server.address)
        context.close()


def opened_ms(studio: Any, name: str) -> float:
    """From the click on Home to the first picture of a trial."""
    card = studio.page.get_by_role("button", name=re.compile(f"^{name}")).first
    card.wait_for()
    began = time.perf_counter()
    card.click()
    studio.page.locator("main[data-screen=tracks][data-frame]").wait_for()
    studio.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)))")
    return 1000 * (time.perf_counter() - began)


def script_ms(studio: Any) -> float:
    """Script a frame while one goes through time, by the browser's account."""
    tools = studio.page.context.new_cdp_session(studio.page)
    tools.send("Performance.enable")

    def script() -> float:
        found = {one["name"]: one["value"] for one in tools.send("Performance.getMetrics")["metrics"]}
        return float(found["ScriptDuration"])

    began = script()
    for _ in range(SCRUBBED):
        studio.press("ArrowRight")
    studio.page.locator(f"main[data-frame='{SCRUBBED + 1}']").wait_for()
    return 1000 * (script() - began) / SCRUBBED


def watched(studio: Any, where: str, what: str) -> None:
    """Note ms in the page each time that the attribute says something else; nothing shown is no picture."""
    studio.page.evaluate(WATCH.replace("WHERE", where).replace("WHAT", what))


def edits_ms(studio: Any) -> float:
    """From the key of an edit, or of its undoing, to its picture; 95 %."""
    watched(studio, "main", "data-head")
    studio.press(".")
    for _ in range(EDITS):
        for key in ("u", "Control+z"):
            before = studio.head
            studio.press(key).acted(before)
    studio.page.wait_for_timeout(200)
    return float(np.percentile(studio.page.evaluate("() => window.times"), 95))


def memory_mb(studio: Any) -> float:
    """Proportional memory of the processes that draw pages; by /proc, so on Linux alone."""
    tools = studio.page.context.browser.new_browser_cdp_session()
    processes = tools.send("SystemInfo.getProcessInfo")["processInfo"]
    found = [_pss(int(one["id"])) for one in processes if one["type"] == "renderer"]
    return max(found, default=float("nan"))


def _pss(process: int) -> float:
    text = Path(f"/proc/{process}/smaps_rollup").read_text("ascii")
    return next(float(line.split()[1]) for line in text.splitlines() if line.startswith("Pss:")) / 1024


def recorded(folder: Path) -> None:
    """A session of eight cameras whose images say the number of their frame."""
    from support.numbered_session import burn

    simulate(folder, scene=Scene(cameras=CAMERAS, seconds=SECONDS, rate_hz=RATE, size_px=SIZE, noise=1.0))
    burn(folder, rate=int(RATE))
    Session.open(folder).run()


def images_ms(studio: Any) -> float:
    """From the key to the right images of all cameras; 95 %."""
    frame, last = int(studio.page.locator("main").get_attribute("data-frame")), round(SECONDS * RATE)
    studio.page.locator(f"[data-images='{frame}']").wait_for()
    watched(studio, "document.querySelector('[data-images]')", "data-images")
    for k in range(KEYS):
        step = 1 if k % 3 else 10
        on = frame + step <= last
        studio.press(("" if step == 1 else "Shift+") + ("ArrowRight" if on else "ArrowLeft"))
        frame += step if on else -step  # the page says it with its next picture
        studio.page.locator(f"[data-images='{frame}']").wait_for()
    return float(np.percentile(studio.page.evaluate("() => window.times"), 95))


def wrong_images(studio: Any, seeks: int) -> float:
    """Tiles that show another frame than the one that was gone to."""
    from support.numbered_session import numbers_shown

    cameras = {f"cam{k}": SIZE for k in range(1, CAMERAS + 1)}
    studio.press("e")  # without lines over the images
    wrong, field = 0, studio.page.get_by_label("Frame", exact=True)
    for frame in np.random.default_rng(3).integers(1, round(SECONDS * RATE) + 1, seeks).tolist():
        field.fill(str(frame))
        field.press("Enter")
        studio.page.locator(f"[data-images='{frame}']").wait_for()
        wrong += sum(shown != frame for shown in numbers_shown(studio.page, cameras))
    return wrong


def measured(*, long: bool, seeks: int) -> Iterator[tuple[str, float]]:
    """The figures by name, each as soon as it is there."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_file(folder, FRAMES)
        with page_of(folder) as studio:
            yield "work", statistics.median(studio.page.evaluate(WORK) for _ in range(5))
            yield "open 60 x 10 000", opened_ms(studio, f"t{FRAMES}")
            studio.idle()
            yield "script of a scrubbed frame", script_ms(studio)
            yield "edit or undo to picture, 95 %", edits_ms(studio)
            yield "memory of the page", memory_mb(studio)
    if long:
        with tempfile.TemporaryDirectory() as name:
            write_file(Path(name), LONG)
            with page_of(Path(name)) as studio:
                yield "open 60 x 100 000", opened_ms(studio, f"t{LONG}")
    with tempfile.TemporaryDirectory() as name:
        recorded(Path(name))
        with page_of(Path(name)) as studio:
            studio.open()
            yield "eight cameras, at once after the first opening, 95 %", images_ms(studio)
            yield "wrong images of random frames", wrong_images(studio, seeks)
            yield "memory of the page, eight cameras", memory_mb(studio)
        with page_of(Path(name)) as studio:
            studio.open()
            yield "eight cameras, key to images, 95 %", images_ms(studio)


def metrics() -> list[Metric]:
    """The short form, without the long file; nothing where there is no browser."""
    try:
        found = dict(measured(long=False, seeks=100))
    except BaseException as error:  # pytest's Skipped, which is no Exception
        if type(error).__name__ != "Skipped":
            raise
        return []
    return [
        Metric(f"{bar.name}, by a fixed work", found[bar.name] / found["work"], "ratio", "less", relative=1.0)
        if bar.unit == "ms"
        else Metric(bar.name, found[bar.name], bar.unit, "less", relative=0.3)
        for bar in BARS
        if bar.name in found
    ]


def main() -> None:
    """Print each figure beside its bar."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true", help="a file of 100 000 frames as well")
    parser.add_argument("--images", type=int, default=SEEKS, help="random frames to go to")
    given = parser.parse_args()
    bars = {bar.name: bar for bar in BARS}
    for name, value in measured(long=given.long, seeks=given.images):
        if bar := bars.get(name):
            print(f"{name:54}{value:10.1f} {bar.unit:8} at most {bar.most:g}", flush=True)


if __name__ == "__main__":
    main()
