"""Findings of figures by their kinds."""

from kinemark.data import Finding


def found(figures, kind):
    """The findings of a kind."""
    return [Finding.of(one) for one in figures["findings"] if one["kind"] == kind]


def kinds(figures, severity=None):
    """The kinds of what was found, in order; of one severity where it is given."""
    return [one["kind"] for one in figures["findings"] if severity in (None, one["severity"])]
