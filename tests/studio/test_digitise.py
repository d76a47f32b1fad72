"""Digitise in the browser: a feeding motion by an operator who only sees the screen, errs, and comes back later."""

import re

import pytest

from kinemark.engine.session import Session
from kinemark.io.answers_csv import read_answers
from support.axe import needed_axe, violations
from support.digitising_person import Person
from support.eating import footage
from support.feeding import NAMES, feeding_in, not_set_up
from support.studio_page import Studio, needed, served, window

FRAMES = 4
COUNT_TONES = "window.tones = 0; const start = OscillatorNode.prototype.start;" + (
    "OscillatorNode.prototype.start = function (...a) { window.tones += 1; return start.apply(this, a); };"
)


@pytest.fixture(scope="module")
def seen():
    return footage(FRAMES / 30)[2].uv


@pytest.fixture
def folder(tmp_path):
    needed()
    return feeding_in(tmp_path / "feeding", FRAMES, confirm=True)


def begun(server, chromium_running, seen):
    context = window(chromium_running)
    context.add_init_script(COUNT_TONES)
    studio = Studio(context, server).enter(server.address)
    studio.page.get_by_role("button", name="feeding", exact=True).click()
    studio.page.get_by_role("button", name="Digitise", exact=True).click()
    studio.page.locator("[data-phase]").wait_for()
    return Person(studio.idle(), seen), context


def test_a_feeding_motion_is_digitised_verified_and_run(folder, seen, chromium_running):
    with served(folder) as server:
        person, context = begun(server, chromium_running, seen)
        page, studio = person.page, person.studio
        assert person.asked() == "Where is ACR1?"
        person.click(30, 470)  # nothing is there
        page.get_by_text("There is no white pixel of a marker").first.wait_for()
        person.answered(lambda: person.click(*person.place("ARM3")))  # a wrong marker, taken back
        person.answered(lambda: page.keyboard.press("Backspace"))
        assert person.asked() == "Where is ACR1?"
        absent, image = (
            page.get_by_role("button", name=re.compile("^Not present")),
            page.get_by_label("Image", exact=True),
        )
        (x, y), within = (absent.bounding_box()[key] for key in "xy"), image.bounding_box()
        assert x > within["x"] + 0.7 * within["width"] and y < within["y"] + 0.2 * within["height"], "upper right"
        person.answered(lambda: absent.click())
        person.answered(
            lambda: page.get_by_label("Question", exact=True).get_by_role("button", name=re.compile("^Undo")).click()
        )
        person.until("cam1", 3, "reference")
        assert person.asked() == "Is this the reference marker, REF?"
        person.answered(lambda: page.keyboard.press("n"))
        assert person.asked() == "Where is the reference marker, REF?"
        person.answered(lambda: person.click(*person.place("REF")))
        assert person.stands()[2] == "reference", "after a correction it is asked again"
        person.until("cam1", 3, "review")
        person.answered(lambda: page.keyboard.press("v"))
        assert person.asked() == "Is this ACR1?"
        person.answered(lambda: page.keyboard.press("n"))
        assert person.asked() == "Click where the centre of ACR1 is."
        u, v = person.place("ACR1")
        person.answered(lambda: person.click(u + 2, v + 3))
        page.locator("tr[data-how=placed]").wait_for()
        stood = person.stands()
        context.close()

        person, context = begun(server_again(server), chromium_running, seen)  # the browser was closed in the midst
        page, studio = person.page, person.studio
        assert person.stands() == stood, "nothing is lost"
        person.until("cam1", 4, "reference")
        page.get_by_label("Frame", exact=True).fill("2")
        page.keyboard.press("Enter")
        page.get_by_role("button", name=re.compile("^Change frame 2")).wait_for()
        page.keyboard.press("r")
        page.locator("[data-phase=review][data-frame='2']").wait_for()
        studio.idle()
        person.until("cam2", 1, "point")
        page.get_by_text("The last frame of cam1 is saved. Next: cam2.").wait_for()
        assert page.evaluate("window.tones") == 1
        person.until("cam3", FRAMES, "done")
        page.get_by_text("the trial is digitised").first.wait_for()
        assert page.evaluate("window.tones") == 3
        page.get_by_role("button", name="Run the trial", exact=True).click()
        page.get_by_text("The trial was run: see Tracks.").wait_for()
        page.get_by_role("button", name="Tracks").click()
        page.get_by_text("Errors expected").first.wait_for()
        assert [one for one in studio.errors if "42" not in one] == []  # refusals are told in words
        context.close()
    trial = Session.open(folder).trial("feeding").run(to="track")
    assert trial.computed == () and trial.trajectories.names == NAMES
    first = read_answers(folder / "answers" / "cam1.csv")
    assert sum(type(one.answer).__name__ == "Undo" for one in first) == 2
    error = abs(trial.trajectories.xyz - footage(FRAMES / 30)[1].xyz)
    assert error.max() < 3.0, "mm; the place that was put by hand is off by 3 px"


def server_again(server):
    """The same server, with the address that opens it in another browser."""
    server.address = server.next_address()
    return server


def test_all_is_digitised_by_keys_alone(folder, seen, chromium_running):
    """The spots are stepped through until the ring is on the marker, as the loupe shows."""
    with served(folder) as server:
        person, context = begun(server, chromium_running, seen)
        page = person.page
        for _ in range(3):
            before = person.stands()
            page.keyboard.press(".")
            person.answered(lambda: page.keyboard.press("Space"))
            assert person.stands()[3] == str(int(before[3]) + 1)
        person.answered(lambda: page.keyboard.press("b"))
        assert page.locator("tr[data-how='not present']").count() == 1
        person.answered(lambda: page.keyboard.press("Backspace"))
        assert person.asked() == "Where is ELB4?"
        context.close()


def test_a_trial_is_set_up_and_the_other_cameras_are_believed(folder, seen, chromium_running):
    """Two cameras by hand; of the third only the reference marker is asked for."""
    with served(not_set_up(folder)) as server:
        context = window(chromium_running)
        page = (studio := Studio(context, server).enter(server.address)).page
        page.get_by_role("button", name="feeding", exact=True).click()
        page.get_by_role("button", name="Digitise", exact=True).click()
        page.get_by_text("Nobody digitises feeding by hand").wait_for()  # once: the foot does not repeat it
        assert studio.note() == ""
        page.get_by_label("Markers, in the order").fill(" ".join(NAMES))
        page.get_by_label("Reference marker, which").select_option("REF")
        page.get_by_label("ask in every frame").uncheck()
        page.get_by_label("take what the other cameras say").check()
        page.get_by_role("button", name="Begin to digitise").click()
        page.locator("[data-phase=point]").wait_for()
        person, pointed = Person(studio.idle(), seen), 0
        person.until("cam3", 1, "point")
        while person.stands()[2] != "done":
            pointed += person.stands()[2] == "point"
            assert person.stands()[2] == "review" or "the reference marker" in person.asked()
            person.go_on()
        assert pointed == 2
        context.close()
    text = (folder / "session.toml").read_text("utf-8")
    assert "# the arm study" in text and "take_proposals = true" in text and "confirm_reference = false" in text


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_whatever_is_asked(folder, seen, chromium_running, theme):
    needed_axe()
    with served(folder) as server:
        context = window(chromium_running, bypass_csp=True)  # axe is put in by evaluation, which the policy forbids
        studio = Studio(context, server, theme=theme).enter(server.address)
        studio.page.get_by_role("button", name="feeding", exact=True).click()
        studio.page.get_by_role("button", name="Digitise", exact=True).click()
        studio.page.locator("[data-phase]").wait_for()
        person, found = Person(studio.idle(), seen), {}
        studio.page.get_by_role("button", name="Start up").click()
        studio.page.get_by_role("button", name="Find them by themselves").wait_for()
        found["start up"] = violations(studio.page)
        studio.page.get_by_role("button", name="Start up").click()
        for phase, keys in {"point": "", "review": "", "verify": "v", "correct": "n"}.items():
            if phase == "review":
                person.until("cam1", 1, "review")
            if keys:
                person.answered(lambda keys=keys: studio.page.keyboard.press(keys))
            assert person.stands()[2] == phase
            found[phase] = violations(studio.page)
        studio.page.keyboard.press("ArrowRight")
        studio.page.locator("[data-phase=looking]").wait_for()
        found["looking"] = violations(studio.page)
        context.close()
        assert [one for of in found.values() for one in of] == []
