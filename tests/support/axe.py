"""What axe finds on a page that everybody should be able to use."""

import pytest

from support.studio_page import AXE

LEVELS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]


def needed_axe():
    """Skip where it is not here."""
    if not AXE.is_file():
        pytest.skip("needs axe-core: python3 dev.py studio")


def violations(page):
    """What axe finds, each with where it is."""
    page.evaluate(AXE.read_text("utf-8"))
    found = page.evaluate("levels => axe.run({runOnly: {type: 'tag', values: levels}})", LEVELS)
    return [
        f"{one['id']}: {one['nodes'][0]['html'][:160]} {one['nodes'][0]['failureSummary'][:200]}"
        for one in found["violations"]
    ]
