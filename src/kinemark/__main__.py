"""The command `kinemark`, and `python -m kinemark`; Ctrl-C ends it at any moment, also while it is imported."""

import os
import signal
import sys

STOPPED = "stopped; what was finished is kept, nothing is half-written, and the same command goes on from there"
STATUS = 130
"""Exit status after Ctrl-C: 128 + SIGINT, by convention."""


def main() -> None:
    """The command."""
    try:
        from .apps.cli import main as command

        try:
            command()
        finally:
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # all is said: Ctrl-C now only ends the interpreter sooner
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C changes nothing
        sys.stderr.write(f"\nkinemark: {STOPPED}\n")
        sys.stderr.flush()
        os._exit(STATUS)  # threads that still decode an image are not waited for


if __name__ == "__main__":
    main()
