"""The studio's server as a process of its own, for tests of its page: `python studio_server.py FOLDER [--faults]`.

With faults the trial comes as a tracker that errs would have left it.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))


def main(folder, *options):
    from kinemark.apps.studio.server import serve
    from kinemark.engine import editing

    if "--faults" in options:
        from support.faults import faulty

        measured = editing.measured_of
        editing.measured_of = lambda *given: faulty(measured(*given))
    port = next((int(option) for option in options if option.isdigit()), 0)
    serve((Path(folder),), port=port, browser=False, say=lambda text: print(text, flush=True))


if __name__ == "__main__":
    main(*sys.argv[1:])
