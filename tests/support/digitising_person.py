"""A person who digitises in the browser: they know where the markers are, and see the screen alone."""

import re

import numpy as np

from support.feeding import NAMES
from support.screen_operator import KEY_S, LOOK_S, MENTAL_S, POINT_S

SEEN_PX = 4.0
"""By how much a place is off that somebody sees."""


class Effort:
    """What a person did, and how long it would take by the keystroke-level model (Card, Moran and Newell 1980)."""

    def __init__(self):
        self.keys = self.clicks = self.decisions = 0

    def key(self, *, decide=False):
        self.keys += 1
        self.decisions += decide

    def click(self, *, decide=False):
        self.clicks += 1
        self.decisions += decide

    @property
    def actions(self):
        return self.keys + self.clicks

    @property
    def seconds(self):
        return KEY_S * self.keys + POINT_S * self.clicks + (MENTAL_S + LOOK_S) * self.decisions


class Person:
    """Who knows where the markers are, reads the question, and clicks; what they see is on the screen alone."""

    def __init__(
        self, studio, seen, names=NAMES, cameras=("cam1", "cam2", "cam3"), size=(512, 512), effort=None, careful=False
    ):
        """seen: (C, M, F, 2) px, NaN where they do not see it; size: of the images, px; careful: whether they look at
        every frame before it is saved, and put right what is off by more than they can see."""
        self.careful = careful
        self.studio, self.page, self.seen, self.names, self.clicks = studio, studio.page, seen, names, 0
        self.cameras, self.size, self.effort = cameras, size, effort or Effort()

    @property
    def screen(self):
        return self.page.locator("[data-phase]")

    def stands(self):
        """Camera, frame, what kind of question, and how many answers are kept."""
        of = self.screen
        return tuple(of.get_attribute(f"data-{name}") for name in ("camera", "frame", "phase", "kept"))

    def asked(self):
        return self.page.locator("section[aria-label=Question] h2").inner_text()

    def place(self, name):
        camera, frame, _, _ = self.stands()
        return self.seen[self.cameras.index(camera), self.names.index(name), int(frame) - 1]

    def click(self, u, v):
        camera, frame, _, _ = self.stands()
        self.page.locator(
            f"[data-shown$='/{camera}/{frame}'], [data-shown*='/{camera}/{frame}?']"
        ).wait_for()  # nobody points at what is not there yet
        box = self.page.get_by_role("img", name=re.compile("^Image of")).bounding_box()
        (width, height), (w, h) = (box["width"], box["height"]), self.size
        scale = min(width / w, height / h)
        x, y = width / 2 + (u + 0.5 - w / 2) * scale, height / 2 + (v + 0.5 - h / 2) * scale
        self.page.mouse.click(box["x"] + x, box["y"] + y)

    def answered(self, do):
        """Do it, until another question is asked."""
        before = self.stands()
        do()
        self.page.locator(f"[data-phase]:not([data-camera='{before[0]}'][data-kept='{before[3]}'])").wait_for()
        self.studio.idle()
        self.clicks += 1

    def go_on(self):
        """Answer the question that is on the screen."""
        asked, phase = self.asked(), self.stands()[2]
        if phase == "review":
            assert asked.startswith("Have successfully detected all markers")
            self.press("v" if self.careful and not all(map(self.right, self.names)) else "Enter")
        elif self.careful and phase == "verify":
            self.press("y" if self.right(self.asked_for()) else "n")
        elif phase == "correct":
            place = self.place(self.asked_for())
            self.press("b") if np.isnan(place).any() else self.answered(lambda: self.click(*place))
        elif phase in ("reference", "verify") or "The other cameras say: here" in asked:
            self.press("y")
        else:
            name = re.match(r"Where is (?:the reference marker, |marker )?(\w+)\?", asked)[1]
            place = self.place(name)
            if np.isnan(place).any():
                self.press("b")
                return
            self.effort.click(decide=True)
            self.answered(lambda: self.click(*place))

    def asked_for(self):
        """The marker that the question is about."""
        return (
            self.page.locator("section[aria-label='Markers of the frame'] tr[aria-current=true] th")
            .inner_text()
            .split()[0]
        )

    def right(self, name):
        """Whether the draft has a marker where they see it; what is said not to be present, they believe."""
        table = self.page.locator("section[aria-label='Markers of the frame'] tbody")
        u, v = table.locator("tr").nth(self.names.index(name)).locator("td").all_inner_texts()[:2]
        off = [] if u == "–" else np.array([float(u), float(v)]) - self.place(name)
        return len(off) == 0 or bool(np.hypot(*off) < SEEN_PX)

    def press(self, key):
        """A key that answers, after a look at what is asked."""
        self.effort.key(decide=True)
        self.answered(lambda: self.page.keyboard.press(key))

    def until(self, camera, frame, phase):
        for _ in range(300):
            if self.stands()[:3] == (camera, str(frame), phase):
                return
            self.go_on()
        raise AssertionError(f"it never came to {camera}, frame {frame}, {phase}: {self.stands()}")
