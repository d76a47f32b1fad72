"""The page in Chromium: every screen opens, everybody can use it, and what is done on it is in the journal."""

import json
import re

import numpy as np
import pytest

from support.axe import needed_axe, violations
from support.numbered_session import numbers_shown
from support.studio_page import Studio, needed_by, window

SEEKS = 25  # the benchmark has a thousand
SCREENS = ("home", "new", "cameras", "tracks", "detect", "labels", "gaps", "angles", "report", "history")
DIALOGS = {
    "?": "Help",
    "Control+k": "Search or command",
    "Shift+W": "Why",
    "Shift+S": "Sign",
    "Shift+F": "Finish",
    "k": "An event",
}


def lines(folder):
    """The journal's entries."""
    path = folder / "edits" / "walk01.jsonl"
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()] if path.is_file() else []


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_screen_opens_without_an_error_and_axe_finds_nothing(folder, walk, chromium_running, theme):
    needed_axe()
    from support.studio_page import served

    with served(folder, "--faults") as server:
        context = window(chromium_running, bypass_csp=True)  # axe is put in by evaluation, which the policy forbids
        studio, found = Studio(context, server, theme=theme).enter(server.address), {}
        for screen in SCREENS:
            if screen == "home":
                studio.page.get_by_role("button", name="walk01", exact=True).wait_for()
            elif screen == "new":
                studio.page.get_by_role("button", name="New session …").click()
            elif screen == "cameras":
                studio.page.get_by_role("button", name="Home", exact=True).click()
                studio.page.get_by_role("button", name=re.compile("^Cameras of")).click()
                studio.page.locator("[data-grade]").wait_for()
            elif screen == "tracks":
                studio.page.get_by_role("button", name="Home", exact=True).click()
                studio.open()
            else:
                studio.page.get_by_role("button", name=re.compile(f"^{screen.title()}")).click()
            studio.idle().press("n")
            studio.page.wait_for_timeout(300)
            found[screen] = violations(studio.page)
        for key, title in DIALOGS.items():
            studio.page.get_by_role("button", name=re.compile("^Tracks")).click()
            studio.page.locator("main[data-screen=tracks]").wait_for()
            studio.idle().press(key)
            studio.page.get_by_role("dialog", name=re.compile(re.escape(title))).wait_for()
            found[title] = violations(studio.page)
            studio.press("Escape")
        context.close()
        assert [one for of in found.values() for one in of] == []
        assert studio.errors == []


def test_the_policy_refuses_nothing_and_the_view_is_drawn(studio):
    studio.open().press("n")
    studio.idle()
    assert studio.errors == []
    picture = studio.page.get_by_role("img", name="Markers, their paths and the cameras in space")
    colours = {tuple(picture.screenshot()[i : i + 64]) for i in range(2000, 6000, 64)}
    assert len(colours) > 20, "the view is flat"


def test_what_the_first_screen_needs_comes_before_all_others(studio):
    """Opened on Tracks, the browser asks for what Tracks needs, and for the other screens when it is drawn."""
    asked, other = [], Studio(studio.page.context, studio.server)
    other.page.on("request", lambda request: asked.append(request.url.rsplit("/", 1)[1]))
    studio.open()
    other.page.goto(studio.server.base + other.asked + "#" + studio.page.url.split("#")[1])
    other.page.locator("main[data-screen=tracks] canvas").first.wait_for()
    needed = {path.name for path in needed_by("Tracks")}
    scripts = [name for name in asked if name.endswith(".js")]
    assert set(scripts[: len(needed)]) == needed
    assert studio.errors == other.errors == []


def test_the_images_are_those_of_the_frame(studio):
    """The number that is burnt into every image is that of the frame, in all cameras, wherever one goes."""
    studio.open().press("e")  # without lines over the images
    cameras = {f"cam{k}": (488, 378) for k in range(1, 6)}
    wrong = []
    for frame in np.random.default_rng(0).integers(1, 121, SEEKS).tolist():
        field = studio.page.get_by_label("Frame", exact=True)
        field.fill(str(frame))
        field.press("Enter")
        studio.page.locator(
            f"[aria-label=Cameras][data-images='{frame}'], [aria-label=Cameras] [data-images='{frame}']"
        ).first.wait_for()
        wrong += [(frame, shown) for shown in numbers_shown(studio.page, cameras) if shown != frame]
    assert wrong == []


def test_an_enlarged_image_is_in_the_camera_s_own_pixels(studio):
    studio.open().press(".", "z")
    part = studio.page.locator("[aria-label=Cameras] [data-part]").first
    part.wait_for()
    assert "/cameras/" in part.get_attribute("data-part")
    assert studio.errors == []


def test_an_act_is_in_the_journal_is_undone_and_done_again(folder, studio):
    studio.open().press(".")
    before = studio.head
    studio.press("u").acted(before)
    assert [edit["kind"] for edit in lines(folder)[-1]["edits"]] == ["claim"]
    assert studio.page.get_by_text(re.compile(r"^saved")).count() == 1
    for key in ("Control+z", "Control+Shift+z"):
        before = studio.head
        studio.press(key).acted(before)
    assert [entry["edits"][0]["kind"] for entry in lines(folder)] == ["claim", "undo", "undo"]


def test_all_is_done_by_keyboard_alone(folder, studio):
    """From Home to a signed trial without the mouse."""
    page = studio.page
    page.get_by_role("button", name="walk01", exact=True).wait_for()
    for _ in range(40):
        if page.evaluate_handle("document.activeElement").as_element().inner_text() == "walk01":
            break
        studio.press("Tab")
    studio.press("Enter")
    page.locator("main[data-screen=tracks] canvas").first.wait_for()
    studio.idle().press(".", "[")
    studio.press("ArrowRight", "ArrowRight", "]")
    before = studio.head
    studio.press("Delete").acted(before)
    before = studio.head
    studio.press("Shift+S")
    page.get_by_role("dialog").wait_for()
    studio.press("Enter").acted(before)
    said = [edit for entry in lines(folder) for edit in entry["edits"]]
    assert [(edit["kind"], edit.get("first"), edit.get("last")) for edit in said] == [
        ("erase", 1, 3),
        ("signed", None, None),
    ]


def test_the_function_that_smooths_a_stretch_is_chosen(folder, studio):
    page = studio.open().page
    studio.press("ArrowRight", "[", ".", "ArrowRight")
    page.get_by_label("Frame", exact=True).fill("40")
    page.keyboard.press("Enter")
    studio.idle().press("]", "m")
    dialog = page.get_by_role("dialog", name=re.compile("^Smooth "))
    assert dialog.get_by_label("Function").locator("option").count() == 3
    dialog.get_by_label("Function").select_option("woltring")
    dialog.get_by_label("Cut-off, Hz").fill("9.5")
    before = studio.head
    studio.press("Enter").acted(before)
    edit = lines(folder)[-1]["edits"][0]
    assert (edit["kind"], edit["function"], edit["cutoff_hz"], edit["last"]) == ("smooth", "woltring", 9.5, 40)


def test_a_name_is_given_and_the_join_is_shown_before(folder, faulty_studio):
    studio, page = faulty_studio.open(), faulty_studio.page
    studio.press("Control+k")
    page.keyboard.type("*91 select")
    studio.press("Enter", "l")
    page.get_by_role("combobox").fill("SACR")
    page.get_by_role("dialog").get_by_text("They go together").wait_for()
    before = studio.head
    studio.press("Enter").acted(before)
    assert lines(folder)[-1]["edits"][0]["name"] == "SACR"


def test_two_windows_do_not_harm_each_other(folder, studio):
    """What one says is shown in the other, which then speaks of what it sees."""
    other = Studio(studio.page.context, studio.server)
    other.page.goto(studio.server.base + other.asked)
    studio.open(), other.open()
    before = studio.head
    studio.press(".", "u").acted(before)
    other.page.locator(f"main[data-head='{studio.head}']").wait_for()
    before = other.head
    other.press(".", ".", "u").acted(before)
    studio.page.locator(f"main[data-head='{other.head}']").wait_for()
    assert [entry["edits"][0]["kind"] for entry in lines(folder)] == ["claim", "claim"]


def test_a_server_that_is_killed_loses_nothing(folder, studio):
    studio.open()
    before = studio.head
    studio.press(".", "u").acted(before)
    after, port = studio.head, re.search(r":(\d+)/", studio.server.base).group(1)
    studio.server.kill()
    studio.page.get_by_role("alert").wait_for()
    studio.press("u")
    studio.page.get_by_text("does not answer").first.wait_for()
    studio.server.start(port)
    studio.errors.clear()
    studio.enter(studio.server.address).open()
    assert studio.head == after
    assert len(lines(folder)) == 1


def test_a_server_that_was_started_anew_lets_an_open_window_in_when_its_address_was_opened(studio):
    """It does not know the window before, and the window says what to do."""
    page = studio.open().page
    port = re.search(r":(\d+)/", studio.server.base).group(1)
    studio.server.kill()
    page.get_by_role("alert").filter(has_text="does not answer").wait_for()
    studio.server.start(port)
    page.get_by_role("alert").filter(has_text="does not know this window").wait_for()
    Studio(page.context, studio.server).enter(studio.server.address)
    page.get_by_role("alert").wait_for(state="detached")
    before = studio.head
    studio.press(".", "u").acted(before)


def test_a_trial_whose_markers_have_no_frame_in_common_is_finished_where_the_person_says(folder, studio):
    page = studio.open().page
    for key, frames in ((".", ("1", "70")), (".", ("50", "120"))):  # one marker is seen late, another one soon no more
        studio.press(key)
        for mark, frame in zip("[]", frames, strict=True):
            page.get_by_label("Frame", exact=True).fill(frame)
            page.keyboard.press("Enter")
            studio.press(mark)
        before = studio.head
        studio.press("Delete").acted(before)
        studio.press("Escape")  # the marks go
    studio.press("Shift+F")
    dialog = page.get_by_role("dialog")
    dialog.get_by_text("There are no frames that all markers have").wait_for()
    dialog.get_by_label("First frame that is left").fill("30")
    dialog.get_by_label("Last frame that is left").fill("90")
    before = studio.head
    studio.press("Enter").acted(before)
    (trim,) = [edit for edit in lines(folder)[-1]["edits"] if edit["kind"] == "trim"]
    assert (trim["first"], trim["last"]) == (30, 90)
