"""A studio over a small folder, and a page in it."""

from dataclasses import replace

from kinemark.apps.studio.app import studio_app
from kinemark.apps.studio.desk import Desk
from kinemark.apps.studio.guard import Guard
from kinemark.apps.studio.shelf import Shelf
from kinemark.data import Trial
from kinemark.io.trial import write_trial
from support.asgi import HOST, Client
from support.edited import paths_without_images

NAMES = ("LKNE", "RKNE", "<img src=x onerror=alert(1)>", "*4")


def file_in(folder, name="walk.c3d", **scene):
    """A file of four markers, one of them with a hostile name and one without any."""
    found = paths_without_images(**scene)
    paths = tuple(replace(path, name=called) for path, called in zip(found, NAMES, strict=True))
    write_trial(Trial("walk", replace(found, paths=paths)), folder / name)
    return folder / name


class Studio:
    """The app behind its guard, and a page that was let in."""

    def __init__(self, *paths, by="op"):
        self.app = studio_app(Desk(Shelf.of(paths), by))
        self.guard = Guard(self.app, [HOST, "localhost:8765"], 8765)
        self.page = self.another_page()

    def another_page(self):
        page = Client(self.guard)
        page.enter(self.guard.token)
        return page

    @property
    def trial(self):
        """Address of the only trial or file."""
        home = self.page.get("/api/home").json()
        cards = [*home["files"], *(trial for session in home["sessions"] for trial in session["trials"])]
        return f"/api/trials/{cards[0]['id']}"

    def head(self):
        return self.page.get(self.trial).json()["head"]

    def act(self, head=None, **act):
        return self.page.post(f"{self.trial}/acts", {"head": head or self.head(), "act": act, "why": ""})
