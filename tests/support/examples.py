"""How many examples a property test tries: what it asks for by day, ten times as many by night."""

import os

PROFILE = os.environ.get("HYPOTHESIS_PROFILE", "steady")


def examples(n: int) -> int:
    """For `settings(max_examples=…)`."""
    return 10 * n if PROFILE == "nightly" else n
