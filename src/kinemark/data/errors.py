"""The one error that tells a user what to do next."""


class KinemarkError(Exception):
    """An impossible whole: no calibration, an unreadable file, a contradictory session.

    The message says what was found, what was wanted, and what to do. A caller's mistake in one
    argument raises `ValueError`, and an absent item (one marker in one frame) is NaN, never an exception.
    """
