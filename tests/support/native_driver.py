"""Calls of `native` with a library of one's own: `python native_driver.py LIBRARY SEEDS`, or `… LIBRARY beyond`.

For a library that was compiled with sanitizers, which ends the process at the first fault.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from kinemark import native
from kinemark.native import compiled_library
from support.native_calls import CALLS, WRONGS, outcome, wrong


def main(path: str, task: str) -> None:
    """Call all functions with right and wrong arrays; or one behind the checks' back, with a size that is too great."""
    compiled_library.PATH = Path(path)
    assert native.status().path == Path(path), native.status().reason
    if task == "beyond":
        native.library().update(100, *(np.ones(8) for _ in range(6)))
    for seed in range(0 if task == "beyond" else int(task)):
        for made in CALLS.values():
            rng = np.random.default_rng(seed)
            outcome(wrong(made(rng), [WRONGS[i] for i in rng.integers(0, len(WRONGS), seed % 3)], rng))
    print("done")


main(*sys.argv[1:])
