"""The studio by keys alone: Tab goes through every screen, what has the focus is seen, the mouse does nothing alone."""

import json

import pytest

from support.studio_page import Studio, served, window

MOST = 120
"""Presses of Tab by which a screen of a small trial is gone through."""
FOCUS = """() => {
    const own = document.activeElement, box = own.getBoundingClientRect(), style = getComputedStyle(own)
    if (own === document.body) return null
    const line = parseFloat(style.outlineWidth), out = Math.max(0, line + parseFloat(style.outlineOffset))
    let [left, top, right, bottom] = [0, 0, innerWidth, innerHeight]
    for (let at = own.parentElement; at; at = at.parentElement) {
        if (getComputedStyle(at).overflow === "visible") continue
        const room = at.getBoundingClientRect()
        left = Math.max(left, room.left), top = Math.max(top, room.top)
        right = Math.min(right, room.right), bottom = Math.min(bottom, room.bottom)
    }
    const cut = [left - box.left + out, top - box.top + out, box.right + out - right, box.bottom + out - bottom]
    return {
        name: (own.getAttribute("aria-label") || own.innerText || own.tagName).slice(0, 40),
        part: (own.closest("main, footer, nav") ?? own.closest("header"))?.tagName ?? "TIME",
        lined: line >= 2 && style.outlineStyle !== "none",
        cut: Math.max(...cut),
        place: `${own.tagName} ${box.left} ${box.top}`,
    }
}"""
"""What has the focus, whether it is outlined, and px of its outline that are cut off; null for nothing."""


def tabbed(page):
    """The stops of Tab, until the first comes again, or nothing has the focus, as after the last of a page."""
    page.evaluate("document.activeElement.blur()")
    found = []
    for _ in range(MOST):
        page.keyboard.press("Tab")
        stop = page.evaluate(FOCUS)
        if stop is None or (found and stop["place"] == found[0]["place"]):
            return found
        found.append(stop)
    raise AssertionError(f"Tab does not come to an end: {[one['name'] for one in found[-8:]]}")


def unseen(stop):
    """A field that stands for its label has no size of its own; the label is outlined."""
    return not stop["name"].startswith("INPUT") and (not stop["lined"] or stop["cut"] > 0.5)


def lines(folder):
    """The journal's entries."""
    return [json.loads(line) for line in (folder / "edits" / "walk01.jsonl").read_text("utf-8").splitlines()]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_tab_goes_through_every_screen_and_what_has_the_focus_is_seen(folder, chromium_running, theme):
    """Lines about what scrolls were cut off outside it; and Tab moved the line of keys at the foot out of sight."""
    with served(folder, "--faults") as server:
        context = window(chromium_running, bypass_csp=True)
        studio = Studio(context, server, theme=theme).enter(server.address)
        page = studio.page
        page.get_by_role("button", name="walk01", exact=True).wait_for()
        stops = {"home": tabbed(page)}
        page.evaluate("document.activeElement.blur()")
        studio.press("Enter")
        page.get_by_text("Errors expected").first.wait_for()
        studio.idle().press("n")
        foot = page.locator("footer li").first.bounding_box()
        stops["tracks"] = tabbed(page)
        assert page.locator("footer li").first.bounding_box() == foot
        for keys, screen in {
            "Shift+L": "labels",
            "Shift+D": "gaps",
            "Shift+H": "history",
            "Shift+C": "cameras",
        }.items():
            page.evaluate("document.activeElement.blur()")
            studio.press(keys)
            page.locator(f"main[data-screen={screen}] h1").first.wait_for()
            stops[screen] = tabbed(page) if studio.idle() else []
        context.close()
    assert [(screen, one) for screen, found in stops.items() for one in found if unseen(one)] == []
    for screen, found in stops.items():
        parts = [one["part"] for one in found]
        first = parts.index("HEADER")  # Tab goes on from where it was
        assert list(dict.fromkeys(parts[first:] + parts[:first]))[:3] == ["HEADER", "NAV", "MAIN"], screen
        assert "FOOTER" in parts, screen


def test_two_markers_are_selected_and_exchanged_by_keys_alone(folder, studio):
    """The second could be added by the mouse alone."""
    studio.open().press(".", ">", ">", "<")
    before = studio.head
    studio.press("x").acted(before)
    (said,) = lines(folder)
    first, second = said["edits"]
    assert {first["name"], second["name"]} == {"SACR", "LASI"}


def test_the_markers_of_a_link_are_selected_by_keys_alone(studio):
    """Its row answered the mouse alone."""
    page = studio.open("labels").page
    link = page.get_by_role("region", name="Lengths of links").get_by_role("button").first
    link.wait_for()
    for _ in range(MOST):
        if link.evaluate("own => own === document.activeElement"):
            break
        studio.press("Tab")
    first, second = link.inner_text().split(" – ")
    studio.press("Enter", "Shift+T")
    page.locator("main[data-screen=tracks]").wait_for()
    selection = page.get_by_role("complementary", name="Problems and selection")
    assert first in selection.inner_text() and second in selection.inner_text()
