"""Numbers as a reader wants them."""

import pytest

from kinemark.report.formatting import number, signed


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [(-0.04, 1, "+0.0"), (-0.0, 0, "+0"), (-0.06, 1, "-0.1"), (0.4, 1, "+0.4"), (-3.0, 2, "-3.00")],
)
def test_what_is_rounded_to_nothing_has_no_minus(value, decimals, text):
    assert signed(value, decimals) == text
    assert number(value, decimals) == text.removeprefix("+")
