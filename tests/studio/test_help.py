"""The help, the line at the foot, and Escape: what a person who does not know how to go on can rely on."""

import json
import re

import pytest

from support.axe import needed_axe, violations
from support.paper import A4_PT, sizes
from support.studio_page import ROOT, Studio, served, window

TABLE = json.loads((ROOT / "ui" / "keys.json").read_text("utf-8"))
TITLES = {screen["id"]: screen["title"] for screen in TABLE["screens"]}
OF_TRIAL = ("tracks", "detect", "digitise", "labels", "gaps", "angles", "report", "history")


def foot(page):
    """The keys of the line at the foot, and what it says of each."""
    found = page.locator("footer li").all_inner_texts()
    return dict(tuple(one.split("\n", 1)) for one in found)


def go(studio, screen):
    studio.page.get_by_role("button", name=re.compile(f"^{TITLES[screen]}")).click()
    studio.page.locator(f"main[data-screen={screen}] h1").first.wait_for()
    return studio.idle()


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_help_is_found_searched_and_left_by_keys_alone(folder, chromium_running, theme):
    needed_axe()
    with served(folder) as server:
        context = window(chromium_running, bypass_csp=True)
        studio = Studio(context, server, theme=theme).enter(server.address)
        page = studio.page
        page.get_by_role("button", name="walk01", exact=True).wait_for()
        studio.press("?")
        page.get_by_role("option").first.wait_for()
        listed = page.get_by_role("option").all_inner_texts()
        assert len(listed) == len(TABLE["topics"])
        assert {one["title"] for one in TABLE["topics"]} == {one.split("\n")[0] for one in listed}
        assert violations(page) == []
        page.keyboard.type("left right")
        page.locator("[data-topic=sides]").wait_for()
        page.keyboard.press("Control+a")
        page.keyboard.type("zebra")
        page.get_by_text("No topic has all of these words.").wait_for()
        assert page.locator("[data-topic]").count() == 0, "nor is another one shown"
        assert violations(page) == []
        page.keyboard.press("Control+a")
        for words, topic in {"square pixels": "aspect", "skip": "skip", "another way": "another-way"}.items():
            page.keyboard.type(words)
            page.locator(f"[data-topic={topic}]").wait_for()
            page.keyboard.press("Control+a")
        page.keyboard.type("gap")
        page.locator("[data-topic=gaps]").wait_for()
        studio.press("ArrowDown")
        page.locator("[data-topic]:not([data-topic=gaps])").wait_for()
        studio.press("Escape")
        page.get_by_role("dialog").wait_for(state="detached")
        studio.open().press("F1")
        page.get_by_role("option").first.wait_for()
        assert page.get_by_role("option").first.inner_text().endswith("Tracks")
        page.keyboard.type("interpolate")
        page.locator("[data-topic=gaps]").wait_for()
        studio.press("Enter")
        page.locator("main[data-screen=gaps]").wait_for()
        assert studio.errors == []
        context.close()


def test_the_foot_says_what_the_next_key_does_on_every_screen(folder, chromium_running):
    """Its keys are those of the table for the screen; pressed, Escape leads where it says."""
    with served(folder, "--faults") as server:
        context = window(chromium_running)
        studio = Studio(context, server).enter(server.address)
        page = studio.page
        page.get_by_role("button", name="walk01", exact=True).wait_for()
        said = {"home": foot(page)}
        assert said["home"]["Enter"] == "open walk01" and "Esc" not in said["home"]
        page.get_by_role("button", name="New session …").click()
        page.locator("main[data-screen=new] h1").wait_for()
        said["new"] = foot(studio.idle().page)
        studio.press("Escape")
        page.locator("main[data-screen=home] h1").wait_for()
        page.get_by_role("button", name=re.compile("^Cameras of")).click()
        page.locator("[data-grade]").wait_for()
        said["cameras"] = foot(studio.idle().page)
        page.get_by_role("navigation", name="Steps").get_by_role("button", name="UM²AS").click()
        page.locator("main[data-screen=um2as] [data-level]").wait_for()
        said["um2as"] = foot(studio.idle().page)
        assert said["um2as"]["Esc"] == "leave UM²AS"
        studio.press("Escape")
        page.locator("main[data-screen=home] h1").wait_for()
        studio.open()
        for screen in OF_TRIAL:
            said[screen] = foot(go(studio, screen).page)
            if screen != "tracks":
                assert said[screen]["Esc"] == "to Tracks", screen
                studio.press("Escape")
                page.locator("main[data-screen=tracks] h1").wait_for()
        assert set(said) == set(TITLES), "every screen"
        for screen, line in said.items():
            assert line["?"] == "help" and len(line) >= 3, screen
        assert said["new"]["Esc"] == said["cameras"]["Esc"] == said["tracks"]["Esc"] == "to Home"
        assert [one for one in studio.errors if "digitise" not in one] == []  # which nobody set up
        context.close()


def test_escape_goes_one_level_up_at_a_time(faulty_studio):
    """Put, marks, problem, selection, screen; a field that is typed into is a level, too."""
    studio, page = faulty_studio.open(), faulty_studio.page
    studio.press("n")
    page.locator("[data-id] [aria-current=true]").wait_for()
    studio.idle().press("[", "ArrowRight", "]", "p")
    page.get_by_label("Frame", exact=True).focus()
    for words in ("no longer put", "take the marks away", "leave the problem", "select nothing", "to Home"):
        if words == "no longer put":
            studio.press("Escape")  # out of the field
        assert foot(page)["Esc"] == words
        studio.press("Escape")
    page.locator("main[data-screen=home]").wait_for()
    assert "Esc" not in foot(page)
    studio.press("Escape")
    assert page.locator("main[data-screen=home]").count() == 1, "Home is the top"


def test_trials_and_folders_are_opened_by_keys_alone(studio):
    page = studio.page
    page.get_by_role("button", name="walk01", exact=True).wait_for()
    studio.press("n")
    assert page.evaluate_handle("document.activeElement").as_element().inner_text() == "walk01"
    studio.press("Enter")
    page.locator("main[data-screen=tracks] canvas").first.wait_for()


def test_a_screen_that_cannot_be_loaded_says_so(studio):
    """The page is loaded once more by itself, and no more where that does not help."""
    studio.page.route(re.compile("History-"), lambda route: route.abort())
    studio.open()
    with studio.page.expect_event("load"):
        studio.page.get_by_role("button", name=re.compile("^History")).click()
    studio.page.get_by_role("heading", name="This screen could not be loaded").wait_for()
    studio.page.unroute(re.compile("History-"))
    studio.page.get_by_role("button", name="Load the page again").click()
    studio.page.get_by_role("heading", name="History").wait_for()


def test_screens_are_printed_light_on_a4(folder, chromium_running):
    """Text upright, over as many pages as it needs; what is drawn on one page across, as large as on the screen."""
    with served(folder) as server:
        context = window(chromium_running)
        context.add_init_script("window.print = () => (window.printed = document.documentElement.dataset.theme)")
        studio = Studio(context, server, theme="dark").enter(server.address)
        page = studio.page
        page.get_by_role("button", name="walk01", exact=True).wait_for()
        assert set(sizes(page.pdf(prefer_css_page_size=True))) == {A4_PT}
        page.emulate_media(media="print")
        assert page.get_by_role("button", name="walk01", exact=True).is_visible(), "names are buttons"
        assert not page.get_by_role("button", name="New session …").is_visible()
        page.emulate_media(media="null")
        for screen in ("tracks", "gaps"):
            go(studio.open() if screen == "tracks" else studio, screen)
            shown = page.locator("main canvas").first.bounding_box()
            page.evaluate("window.printed = null")
            studio.press("Shift+P")
            for _ in range(100):
                if page.evaluate("window.printed") == "light":
                    break
                page.wait_for_timeout(50)
            assert page.evaluate("window.printed") == "light"
            assert page.locator(":root").get_attribute("data-theme") == "dark", "afterwards it is as it was"
            assert sizes(page.pdf(prefer_css_page_size=True)) == [A4_PT[::-1]]
            page.emulate_media(media="print")
            printed = page.locator("main canvas").first.bounding_box()
            assert printed["width"] / printed["height"] == pytest.approx(shown["width"] / shown["height"], rel=0.02)
            page.emulate_media(media="null")
        assert studio.errors == []
        context.close()
