"""How many threads matrix products use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits

THREADS = 1
"""BLAS threads in calibrations, runs and fills; chosen: in `fill` of 224 gaps of 41 markers two took twice the
processor's time of one, and no less of the clock's."""


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Matrix products in one thread: ours are small, and threads that wait for work cost more than they bring.

    It also decorates a function. Afterwards the threads are as many as before. SciPy brings a BLAS of its own, which is
    loaded here, as one that is loaded later would have as many threads as there are processors.
    """
    import scipy.linalg  # noqa: F401  # not where nothing is computed: it takes a tenth of a second

    with threadpool_limits(THREADS, user_api="blas"):
        yield
