"""The studio's server as a process of its own, for tests of its page.

Processes are forked from one that has read all modules before, so that a server is there in a moment. With faults the
trial comes as a tracker that errs would have left it.
"""

import multiprocessing
from pathlib import Path

from support.studio_seen import write_stacks_when_asked

MODULES = ["kinemark.apps.studio.server", "kinemark.apps.studio.app", "kinemark.engine.editing.editing", "uvicorn"]
FORKS = "forkserver" in multiprocessing.get_all_start_methods()


def process_of(folder, stacks, *options):
    """A process that serves a folder, and the pipe by which it says what a terminal would show.

    Its stacks go into the file `stacks` when it gets the signal for that.
    """
    context = multiprocessing.get_context("forkserver" if FORKS else "spawn")
    if FORKS:
        context.set_forkserver_preload(MODULES)
    said, says = context.Pipe(duplex=False)
    process = context.Process(target=serve_into, args=(says, str(folder), str(stacks), *options))
    process.start()
    says.close()  # ours, so that the pipe ends when the server does
    return process, said


def serve_into(says, folder, stacks, *options):
    """Serve until the process is ended. Options: `--faults`, or the number of a port."""
    write_stacks_when_asked(stacks)
    from kinemark.apps.studio.server import serve
    from kinemark.engine.editing import editing

    if "--faults" in options:
        from support.faults import faulty

        measured = editing.measured_of
        editing.measured_of = lambda *given: faulty(measured(*given))
    port = next((int(option) for option in options if option.isdigit()), 0)
    serve((Path(folder),), port=port, browser=False, say=says.send)
