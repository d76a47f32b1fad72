"""An operator who knows the keys and sees the screen, and nothing else: no address is asked, no record is read.

They count what they do, and how long a person would take for it by the keystroke-level model (Card, Moran and Newell
1980): a key, a mental act before each decision, a look at what came.
"""

import re

KEY_S, MENTAL_S, LOOK_S, POINT_S = 0.2, 1.35, 1.0, 1.1
"""s of a key, a decision, a look and a movement of the mouse with its click; of the model."""
MOST = 60  # acts after which the operator gives up


class Operator:
    def __init__(self, studio):
        self.studio, self.page = studio, studio.page
        self.actions, self.seconds, self.did = 0, 0.0, []

    def key(self, key, *, decide=False, what=""):
        """Press a key; where it is a choice, after a thought about what is shown."""
        self.actions += 1
        self.seconds += KEY_S + (MENTAL_S + LOOK_S if decide else 0.0)
        self.did.append(f"{key} {what}".strip())
        self.studio.press(key)

    def act(self, key, what=""):
        """A key that changes the trial, and a look at whether it did."""
        before = self.studio.head
        self.key(key, decide=True, what=what)
        self.studio.acted(before)

    def mend(self):
        """The whole trial: problems, names, gaps, and the end."""
        self.problems()
        self.names()
        self.gaps()

    def problems(self):
        """Take what is proposed until looking on is not worth it."""
        self.key("n")
        for _ in range(MOST):
            if self.page.get_by_text("Looking on is not worth it.").count():
                return
            shown = self.page.locator("[data-id] [aria-current=true]")
            shown.wait_for()
            self.act("Enter", shown.locator("button[data-first=yes] b").inner_text())
        raise AssertionError("the list of problems never ended")

    def names(self):
        """Tracks without a name: the one that is proposed, else it is no marker."""
        self.key("Shift+L")
        self.page.locator("main[data-screen=labels]").wait_for()
        self.studio.idle()
        for _ in range(MOST):
            asked = self.page.locator("[data-track^='*']")
            if not asked.count():
                return
            self.key("n")
            row = self.page.locator("[data-track^='*'][aria-current=true]")
            row.wait_for()
            proposed = "→" in row.inner_text()
            self.act("Enter" if proposed else "Delete", row.inner_text().replace("\n", " "))
        raise AssertionError("tracks without a name never ended")

    def proposed_names(self):
        """Tracks for which a name is proposed; what has none is left out at the end."""
        self.key("Shift+L")
        self.page.locator("main[data-screen=labels]").wait_for()
        self.studio.idle()
        for _ in range(MOST):
            if not self.page.locator("[data-track]").get_by_text("→").count():
                return
            self.key("n")
            row = self.page.locator("[data-track][aria-current=true]")
            row.wait_for()
            if "→" in row.inner_text():
                self.act("Enter", row.inner_text().replace("\n", " "))
        raise AssertionError("names that are proposed never ended")

    def finish(self, file):
        """All to one length, the rest left out; the trial is run and its file is named."""
        self.key("Shift+F", decide=True)
        self.page.get_by_role("button", name="Finish and write").click()
        self.actions, self.seconds = self.actions + 1, self.seconds + POINT_S + LOOK_S
        self.did.append("Finish and write")
        self.studio.ran()
        self.key("Shift+F")
        self.page.get_by_role("button", name="Only write").click()
        self.actions, self.seconds = self.actions + 1, self.seconds + POINT_S + LOOK_S
        self.page.get_by_text(f"Written: {file}").wait_for()

    def gaps(self):
        """All below the limit at once, and the rest one by one, by the best there is."""
        self.key("Shift+D")
        self.page.locator("main[data-screen=gaps]").wait_for()
        self.studio.idle()
        self.page.get_by_text(re.compile(r"\d+ undecided of \d+$")).wait_for()
        if not self.page.get_by_role("button", name=re.compile("^Fill 0 gaps")).count():
            self.act("Shift+Enter", self.page.get_by_role("button", name=re.compile(r"^Fill \d+ gap")).inner_text())
        for _ in range(MOST):
            self.studio.idle()
            if self.page.get_by_text(re.compile("^0 undecided")).count():
                return
            self.key("n")
            way = self.page.get_by_role("button", name=re.compile("^Fill by"))
            way.wait_for()
            self.act("Enter", way.inner_text())
        raise AssertionError("gaps never ended")
