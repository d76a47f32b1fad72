"""On a window of 400 px nothing lies over anything else, and nothing that can be pressed is cut off."""

import re

import pytest

from support.studio_page import Studio, served, window

SCREENS = ("cameras", "detect", "labels", "gaps", "report", "history", "UM²AS")
OUTSIDE = """() => [...document.querySelectorAll('main button, main a.button, header button')]
    .filter((e) => !e.closest('[role=table], table') && e.checkVisibility())
    .map((e) => [e.innerText || e.ariaLabel, e.getBoundingClientRect()])
    .filter(([, at]) => at.width && (at.right > innerWidth + 1 || at.left < -1)).map(([words]) => words)"""
OVER = """() => {
    const head = document.querySelector('header:has(nav)');
    const parts = [...head.querySelectorAll('button, [aria-current], [role=status] > *')];
    const at = parts.map((e) => [e.innerText || e.ariaLabel, e.getBoundingClientRect()]).filter(([, b]) => b.width);
    return at.flatMap(([a, p], i) => at.slice(i + 1)
        .filter(([, q]) => Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1).map(([b]) => `${a} over ${b}`));
}"""


@pytest.fixture
def narrow(folder, chromium_running):
    with served(folder) as server:
        context = window(chromium_running, 400, 800, bypass_csp=True)
        yield Studio(context, server).enter(server.address)
        context.close()


def test_nothing_is_cut_off_or_lies_over_another(narrow):
    page = narrow.page
    page.get_by_role("button", name="walk01", exact=True).wait_for()
    assert page.evaluate(OVER) == [] and page.evaluate(OUTSIDE) == []
    page.get_by_role("button", name="walk01", exact=True).click()
    page.locator("main[data-screen=tracks][data-busy=no]").wait_for()
    for screen in SCREENS:
        page.get_by_role("button", name=re.compile(f"^{screen}", re.IGNORECASE)).first.click()
        page.locator(f"main[data-screen={screen.replace('²', '2').lower()}][data-busy=no]").wait_for()
        assert page.evaluate(OVER) == [] and page.evaluate(OUTSIDE) == [], screen
