"""What happens while the page is open: runs, and trials that others have said something of."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import threading
import time
from typing import Annotated

from fastapi import APIRouter, Depends, WebSocket, WebSocketDisconnect
from starlette.requests import HTTPConnection

from ...data import KinemarkError
from ...data.progress import Cancelled
from ...engine.jobs import Job, RunningJob
from . import messages as m
from .desk import Desk
from .images import mosaics_of
from .shelf import Place

LOOK_S = 1.0
"""s between two looks whether another process wrote into a journal; chosen."""
MOST_WAITING = 200
"""Messages that a page may be behind; chosen: then it is gone, and loads anew."""
MOST_JOBS = 50
"""Runs that are remembered; chosen."""


def _waits_for(busy: Place, wanted: Place) -> str:
    """Why a job is not begun while another of its session goes on."""
    already = " already" if busy == wanted else ""
    if busy.trial is None:
        return f"The cameras of this session are being calibrated{already}. Wait until that is done."
    return f"{busy.trial} of this session is running{already}. Wait for it, or cancel it."


class Live:
    """Tells all open pages; and runs trials, one at a time of a session."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.jobs: dict[str, m.Job] = {}
        self.failed: dict[str, str] = {}
        self._running: dict[str, tuple[Place, RunningJob]] = {}
        self._pages: dict[asyncio.Queue[str], asyncio.AbstractEventLoop] = {}
        self._heads: dict[str, str] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()

    def tell(self, said: m.Job | m.TrialMoved) -> None:
        """Every open page."""
        text = said.model_dump_json()
        for queue, loop in list(self._pages.items()):
            with contextlib.suppress(RuntimeError):  # its loop has ended
                loop.call_soon_threadsafe(self._put, queue, text)

    def moved(self, trial: str, head: str) -> None:
        """A trial's journal has gone on, or it was run."""
        self._heads[trial] = head
        self.tell(m.TrialMoved(trial=trial, head=head))

    def look(self) -> None:
        """Tell of journals that another process has written to."""
        for trial, head in self.desk.heads().items():
            if self._heads.setdefault(trial, head) != head:
                self.moved(trial, head)

    def run(self, key: str, to: str) -> m.Job:
        """Run a trial in a process of its own.

        Raises:
            KinemarkError: it is a file, or a trial of its session is running.
        """
        place = self.desk.place(key)
        if place.trial is None:
            raise KinemarkError(f"{place.name} is a file: there is nothing to run.")
        return self._start(key, place, Job(place.path, place.trial, to))

    def calibrate(self, key: str) -> m.Job:
        """Calibrate a session in a process of its own; raises as `run` does."""
        place = Place(self.desk.shelf.session(key))
        return self._start(key, place, Job(place.path, ""))

    def _start(self, key: str, place: Place, job: Job) -> m.Job:
        """One job at a time of a session."""
        with self._lock:
            if busy := [other for other, _ in self._running.values() if other.path == place.path]:
                raise KinemarkError(_waits_for(busy[0], place))
            number = str(next(self._numbers))
            started = job.start()
            self._running[number] = place, started
        self.failed.pop(key, None)
        self._say(m.Job(id=number, trial=key, state="running"))
        threading.Thread(target=self._follow, args=(number, key, started), daemon=True).start()
        return self.jobs[number]

    def cancel(self, key: str) -> m.Job:
        """Stop the run of a trial; what was finished is kept.

        Raises:
            KinemarkError: it is not running.
        """
        place = self.desk.place(key)
        for number, (other, running) in list(self._running.items()):
            if other == place:
                self._say(self.jobs[number].model_copy(update={"state": "cancelled", "seconds_left": None}))
                running.cancel()
                return self.jobs[number]
        raise KinemarkError(f"{place.name} is not running.")

    def close(self) -> None:
        """The server ends, and its runs with it."""
        for _, running in list(self._running.values()):
            running.cancel()

    def _follow(self, number: str, key: str, running: RunningJob) -> None:
        """Until a run has ended."""
        began, stage, words = time.monotonic(), "", ""
        try:
            for name, done, total in running.progress():
                began, stage = (began, stage) if name == stage else (time.monotonic(), name)
                self._progress(number, name, done / total if total else None, time.monotonic() - began)
        except (KinemarkError, Cancelled) as error:
            words = str(error)
        self._running.pop(number, None)
        job = self.jobs[number]
        if job.state == "running":
            if words:
                self.failed[key] = words
            update = {"state": "failed" if words else "done", "words": words, "progress": None, "seconds_left": None}
            self._say(job.model_copy(update=update))
        self.desk.forget(key)
        with contextlib.suppress(KinemarkError):
            document = self.desk.document(key)
            self.moved(key, document.head)
            if not self._running and (mosaics := mosaics_of(document)) is not None:
                mosaics.begin()  # the processors are free, and somebody is likely to look at it next

    def _progress(self, number: str, stage: str, share: float | None, seconds: float) -> None:
        left = seconds * (1 - share) / share if share else None
        if self.jobs[number].state == "running":
            self._say(self.jobs[number].model_copy(update={"stage": stage, "progress": share, "seconds_left": left}))

    def _say(self, job: m.Job) -> None:
        self.jobs[job.id] = job
        while len(self.jobs) > MOST_JOBS:
            self.jobs.pop(next(iter(self.jobs)))
        self.tell(job)

    def _put(self, queue: asyncio.Queue[str], text: str) -> None:
        if queue.full():
            self._pages.pop(queue, None)
        else:
            queue.put_nowait(text)

    async def page(self, socket: WebSocket) -> None:
        """Speak to a page until it is gone."""
        queue: asyncio.Queue[str] = asyncio.Queue(MOST_WAITING)
        self._pages[queue] = asyncio.get_running_loop()
        speaking = asyncio.create_task(self._speak(socket, queue))
        try:
            while True:
                await socket.receive_text()  # nothing is asked here; this ends when the page is gone
        except (WebSocketDisconnect, KeyError):
            pass
        finally:
            speaking.cancel()
            self._pages.pop(queue, None)

    async def _speak(self, socket: WebSocket, queue: asyncio.Queue[str]) -> None:
        for job in list(self.jobs.values()):
            await socket.send_text(job.model_dump_json())
        while queue in self._pages:
            try:
                text = await asyncio.wait_for(queue.get(), LOOK_S)
            except TimeoutError:
                await asyncio.to_thread(self.look)
                continue
            await socket.send_text(text)
        await socket.close()


async def live_of(connection: HTTPConnection) -> Live:
    """That of the app; awaited, so that no thread is waited for."""
    live = connection.app.state.live
    assert isinstance(live, Live)
    return live


TheLive = Annotated[Live, Depends(live_of)]
router = APIRouter(prefix="/api")


@router.websocket("/live")
async def speak(socket: WebSocket, live: TheLive) -> None:
    """Jobs and trials that moved, as they do."""
    await socket.accept()
    await live.page(socket)


@router.get("/jobs")
def get_jobs(live: TheLive) -> list[m.Job]:
    """Runs of trials since the server was started."""
    return list(live.jobs.values())


@router.post("/trials/{trial}/run")
def post_run(trial: str, live: TheLive, body: m.RunBody | None = None) -> m.Job:
    """Run a trial."""
    return live.run(trial, (body or m.RunBody()).to)


@router.delete("/trials/{trial}/run")
def delete_run(trial: str, live: TheLive) -> m.Job:
    """Stop the run of a trial."""
    return live.cancel(trial)
