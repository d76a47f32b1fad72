"""The command `kinemark`, and `python -m kinemark`; Ctrl-C ends it at any moment, also while it is imported."""

import _thread
import gc
import os
import signal
import sys
import threading

STOPPED = "stopped; what was finished is kept, nothing is half-written, and the same command goes on from there"
STATUS = 130
"""Exit status after Ctrl-C: 128 + SIGINT, by convention."""
AGAIN_S = 0.01
"""s after which a Ctrl-C that was dropped comes again; chosen, as what dropped it has long ended then."""

COLLECTED = 10_000
"""New objects after which Python looks for circles among them, 700 by itself; chosen for speed: imports make a million
that stay, and looking through them was a tenth of the start."""


def main() -> None:
    """The command."""
    gc.set_threshold(COLLECTED)
    sys.unraisablehook = _not_dropped
    try:
        from .apps.cli import main as command

        try:
            command()
        finally:
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # all is said: Ctrl-C now only ends the interpreter sooner
    except BaseException as error:
        if not _interrupted(error):
            raise
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C changes nothing
        sys.stderr.write(f"\nkinemark: {STOPPED}\n")
        sys.stderr.flush()
        os._exit(STATUS)  # threads that still decode an image are not waited for


def _interrupted(error: BaseException | None) -> bool:
    """Whether it is a Ctrl-C, which is the cause of another error while a class or a compiled module is made."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__
    return error is not None


def _not_dropped(dropped: "sys.UnraisableHookArgs") -> None:
    """Python drops what is raised where nobody can catch it, as while a module or an object is let go."""
    if dropped.exc_type is KeyboardInterrupt:
        threading.Timer(AGAIN_S, _again).start()
    else:
        sys.__unraisablehook__(dropped)


def _again() -> None:
    """Ctrl-C comes again."""
    main_thread = threading.main_thread().ident
    if main_thread and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main_thread, signal.SIGINT)  # also where the command waits
    else:
        _thread.interrupt_main()


if __name__ == "__main__":
    main()
