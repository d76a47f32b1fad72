"""What NumPy alone gives, where there are compiled parts."""

import pytest

from kinemark import native
from kinemark.native import PLAIN


def plainly(function, *args, **parameters):
    """The result of a function without the compiled library."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(PLAIN, "1")
        assert native.library() is None
        return function(*args, **parameters)
