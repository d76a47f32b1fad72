"""A person who follows the menu of UM²AS in the browser, level by level; what they do is counted."""

import re

from support.digitising_person import Effort
from support.studio_page import Studio

BALLS = 8


class Guide:
    """Only what the screen shows is used: entries by their titles, Escape, the space bar."""

    def __init__(self, studio, effort=None):
        self.studio, self.page, self.effort = studio, studio.page, effort or Effort()

    def open(self, session):
        """From Home, by the card of the session."""
        self.click(self.page.get_by_role("button", name=f"Cameras of {session}"))
        self.page.locator("main[data-screen=cameras]").wait_for()
        self.click(self.page.get_by_role("button", name="UM²AS", exact=True))
        self.page.get_by_role("heading", name="UM²AS", exact=True).wait_for()
        return self.idle()

    def make(self, folder):
        """A session from the recordings of a folder, as they are proposed; then its menu."""
        self.click(self.page.get_by_role("button", name="New session …"))
        self.click(self.page.get_by_role("button", name=re.compile(folder)))
        self.click(self.page.get_by_role("button", name="Make it, then calibrate"))
        self.page.get_by_role("heading", name="Cameras & calibration").wait_for()
        self.click(self.page.get_by_role("button", name="UM²AS", exact=True))
        self.page.get_by_role("heading", name="UM²AS", exact=True).wait_for()
        return self.idle()

    def threshold(self, level):
        """Of all cameras, on the screen where balls are pointed at."""
        self.page.locator("canvas[data-camera=cam1]").wait_for()
        self.page.get_by_role("slider", name=re.compile("^Threshold")).fill(str(level))
        self.click(self.page.get_by_role("button", name="Keep for all"))
        self.page.get_by_text(f"The threshold of all cameras is {level}").wait_for()
        return self.idle()

    def click_ball(self, uv, size=512):
        """A place of the square image of balls that is shown."""
        box = self.page.locator("canvas[data-camera^=cam]").bounding_box()
        scale = box["width"] / size
        self.page.mouse.click(box["x"] + (uv[0] + 0.5) * scale, box["y"] + (uv[1] + 0.5) * scale)

    def point_at_balls(self, places, size=512):
        """All balls of all cameras at (C, N, 2) px; a row more than there are balls is the reference marker's."""
        for c, own in enumerate(places):
            self.page.locator(f"canvas[data-camera=cam{c + 1}]").wait_for()
            for n, uv in enumerate(own):
                ball = f"[data-ball='cam{c + 1} {n + 1 if n < BALLS else 'reference marker'}']"
                self.page.locator(f"{ball}[aria-current=step]").wait_for()
                self.idle().effort.click(decide=True)
                self.click_ball(uv, size)
                self.page.locator(f"{ball}[data-seen=true]").wait_for()
            if len(own) == BALLS:
                self.page.locator(f"[data-ball='cam{c + 1} reference marker'][aria-current=step]").wait_for()
                self.idle().key("b")
        return self.idle()

    def set_up(self, markers, reference=None, *, every=1, proposals=False, history=2):
        """Start-up of digitising: so many markers, or names, which of them is the reference marker, one frame of so
        many, whether the other cameras are believed, and for how many frames a hidden marker is remembered."""
        self.page.get_by_label("Markers, in the order").fill(markers)
        if reference is not None:
            self.page.get_by_label("Reference marker, which").select_option(reference)
            self.page.get_by_label("ask in every frame").uncheck()
        if every > 1:
            self.page.get_by_label("frames skipped").fill(str(every))
        if history > 2:
            self.page.get_by_label("remember a hidden marker").fill(str(history))
        if proposals:
            self.page.get_by_label("take what the other cameras say").check()
        self.click(self.page.get_by_role("button", name="Begin to digitise"))
        self.page.locator("[data-phase=point]").wait_for()
        return self.idle()

    def idle(self):
        self.studio.idle()
        return self

    def click(self, what, *, decide=False):
        self.effort.click(decide=decide)
        what.click()

    def key(self, key, *, decide=False):
        self.effort.key(decide=decide)
        self.page.keyboard.press(key)

    def entry(self, title):
        return self.page.get_by_role("navigation", name="Menu").get_by_role(
            "button", name=re.compile(f"^{re.escape(title)}")
        )

    def choose(self, *titles):
        """Entries one below the other."""
        for title in titles:
            self.click(self.entry(title), decide=True)
            elsewhere = self.page.locator("main:not([data-screen=um2as])")
            self.page.get_by_role("heading", name=title, exact=True, level=1).or_(elsewhere).first.wait_for()
            self.idle()
        return self

    def state(self, title):
        """done, to be done, waits … as the entry says it."""
        pill = self.entry(title).locator("[data-state]")
        return pill.get_attribute("data-state") if pill.count() else ""

    def words(self, title):
        return self.entry(title).inner_text()

    def up(self, screen_or_title):
        """Escape, once more out of a field that is typed into, until the level or screen is shown."""
        if self.page.evaluate(
            "document.activeElement?.matches('input:not([type=checkbox], [type=range]), textarea, select')"
        ):
            self.key("Escape")
        self.key("Escape")
        self.page.get_by_role("heading", name=screen_or_title, exact=True, level=1).wait_for()
        return self.idle()

    def process(self):
        """Enter, and what is said of it."""
        self.key("Enter", decide=True)
        self.page.locator("footer [role=status]", has_text="Written").wait_for()
        self.idle()
        return self


def entered(context, server, **options):
    return Guide(Studio(context, server, **options).enter(server.address))
