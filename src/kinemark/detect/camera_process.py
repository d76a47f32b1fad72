"""Cameras detected by other processes: a process runs one thread of Python at a time, and half of detection is Python.

Each is a fresh interpreter that reads tasks from its standard input and writes to its standard output what comes of
them. So nothing of the calling script is run again, as it would be by `multiprocessing` where there is no fork, and no
thread of the caller is in the way, as it would be where there is one.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from queue import SimpleQueue
from typing import Any, BinaryIO

from ..data import KinemarkError
from ..data.array_types import Bools
from ..data.method import Method
from ..numerics.blas_threads import one_blas_thread
from .blobs import Blobs
from .detect_camera import detect_camera
from .frame_source import FrameSource

DetectCamera = Callable[[FrameSource, str, Method, Bools | None, Callable[[int], None]], tuple[Blobs, bool]]
"""What `detect_camera` takes and gives."""
PATIENCE_S = 5.0
"""For the end of a process; chosen: batches take less than one, and learning at most that."""
BEGIN = f"from {__name__} import serve; serve()"


@contextmanager
def camera_processes(number: int) -> Iterator[DetectCamera]:
    """`detect_camera` in so many processes, for as many threads at once; they end with the context.

    What it is called with must be importable by another interpreter: see `pickle`.

    Raises:
        KinemarkError: besides what `detect_camera` raises, a process ended, as where the memory is full.
    """
    processes = [_CameraProcess() for _ in range(number)]
    idle: SimpleQueue[_CameraProcess] = SimpleQueue()
    for process in processes:
        idle.put(process)

    def detected(*task: Any) -> tuple[Blobs, bool]:
        process = idle.get()
        try:
            return process.detect(*task)
        finally:
            idle.put(process)

    try:
        yield detected
    finally:
        for process in processes:
            process.end()


class _CameraProcess:
    """Another interpreter, which detects one camera after the other."""

    def __init__(self) -> None:
        """Start it, with the modules that this one finds, and none of the folder where it happens to start."""
        there = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", BEGIN], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=there
        )

    def detect(
        self, source: FrameSource, name: str, method: Method, mask: Bools | None, tell: Callable[[int], None]
    ) -> tuple[Blobs, bool]:
        """As `detect_camera`."""
        try:
            with self._alive(name):
                _say((source, name, method, mask), self._process.stdin)
            while isinstance(said := self._heard(name), int):
                tell(said)
        except BaseException:
            self.end()  # it would go on with what nobody waits for
            raise
        if isinstance(said, Exception):
            raise said
        return said

    def _heard(self, camera: str) -> Any:
        with self._alive(camera):
            return pickle.load(self._process.stdout)  # type: ignore[arg-type]

    @contextmanager
    def _alive(self, camera: str) -> Iterator[None]:
        try:
            yield
        except (EOFError, OSError) as error:
            raise KinemarkError(
                f"Camera {camera}: the process that looked for its markers ended (status {self._process.wait()}). "
                "Where the memory is full, run with --threads 1."
            ) from error

    def end(self) -> None:
        """Stop it: it ends by itself, and leaves no file half written, when it finds that nobody listens."""
        for stream in (self._process.stdin, self._process.stdout):
            with suppress(OSError):  # what nobody took is lost
                stream.close()  # type: ignore[union-attr]
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


@one_blas_thread()
def serve() -> None:
    """What the other process does: task after task, until there are no more or nobody listens."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the caller, who gets it as well, decides
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever prints does not come between the answers
    with suppress(EOFError, BrokenPipeError):
        while True:
            _say(_answer(*pickle.load(sys.stdin.buffer), lambda frames: _say(frames, answers)), answers)


def _answer(*task: Any) -> tuple[Blobs, bool] | Exception:
    try:
        return detect_camera(*task)
    except BrokenPipeError:
        raise
    except Exception as error:
        if not isinstance(error, KinemarkError):
            error.add_note(traceback.format_exc())  # which the other process cannot know
        return error


def _say(what: object, to: Any) -> None:
    """To the other side, at once."""
    stream: BinaryIO = to
    pickle.dump(what, stream)
    stream.flush()
