"""By day property tests are alike on every machine; by night (`--hypothesis-profile=nightly`) they try more, at random.

None fails because a machine is slow, and each process uses one core. What Hypothesis keeps lies in pytest's own cache,
so that tests leave nothing where they are started.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # two processes with two threads each would only wait for each other
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.configuration import set_hypothesis_home_dir

pytest.register_assert_rewrite("support")

common = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("steady", common, derandomize=True)
settings.register_profile("nightly", common, derandomize=False, max_examples=1000, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))


def pytest_configure(config: pytest.Config) -> None:
    """Where examples that failed are kept."""
    if config.pluginmanager.hasplugin("cacheprovider"):
        set_hypothesis_home_dir(config.cache.mkdir("hypothesis"))
