"""How many examples a property test tries: what it asks for by day, ten times as many by night."""

from hypothesis import settings


def examples(n: int) -> int:
    """For `settings(max_examples=…)`."""
    return 10 * n if settings.get_current_profile_name() == "nightly" else n
