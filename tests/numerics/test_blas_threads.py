"""Matrix products have one thread in a fill, whatever the environment says, and as many as before afterwards."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from kinemark.fill import Linear, fill
from kinemark.numerics.blas_threads import THREADS, one_blas_thread
from support.filling import segment, trial_of, with_gap


def blas_threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture
def two_threads():
    with threadpool_limits(2, user_api="blas"):
        if blas_threads() != {2}:
            pytest.skip("this BLAS keeps to one thread")
        yield


def test_threads_are_limited_within_and_restored_after_also_after_an_error(two_threads):
    with pytest.raises(ZeroDivisionError), one_blas_thread():
        assert blas_threads() == {THREADS}
        1 / 0  # noqa: B018
    assert blas_threads() == {2}


def test_fill_limits_them_itself(two_threads, monkeypatch):
    seen = []
    monkeypatch.setattr(
        sys.modules[fill.__module__], "without_outliers", lambda motion: seen.append(blas_threads()) or motion
    )
    trajectories = trial_of(with_gap(segment())).trajectories
    assert fill(trajectories, method=Linear(), limit_mm=np.inf).gaps[0].method == "linear"
    assert seen == [{THREADS}] and blas_threads() == {2}


LATER = """
from kinemark.numerics.blas_threads import one_blas_thread
from threadpoolctl import threadpool_info
with one_blas_thread():
    import scipy
    scipy.linalg.lapack.dpotrf
    print([one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"])
"""


def test_a_blas_that_comes_later_has_one_thread_too():
    """SciPy has its own, and is imported where it is first used: fills took five times the processor's time."""
    environment = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}
    said = subprocess.run([sys.executable, "-c", LATER], env=environment, capture_output=True, text=True, check=True)
    assert set(json.loads(said.stdout)) == {THREADS}
