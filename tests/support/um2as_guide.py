"""A person who follows the menu of UM²AS in the browser, level by level; what they do is counted."""

import re

from support.digitising_person import Effort
from support.studio_page import Studio


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
        return self.page.get_by_role("navigation", name="Menu").get_by_role("button", name=re.compile(f"^{re.escape(title)}"))

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
        """Escape, until the level or screen is shown."""
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
