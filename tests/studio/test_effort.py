"""What is counted of a flow is what a person would do: every key and click, and what is filled in at once."""

import subprocess
import sys
from urllib.parse import quote

import pytest

from support.effort import EFFORT, HAND_S, Effort
from support.screen_operator import KEY_S, MENTAL_S, POINT_S
from support.studio_page import ROOT, window

PAGE = """<input id=text><input id=number type=number><input id=day type=date><input id=level type=range max=255>
<input id=on type=checkbox><select id=of><option>a<option>b</select><button>Go</button>"""


def test_every_key_and_click_is_counted_once(chromium_running):
    context, effort = window(chromium_running), Effort()
    page = context.new_page()
    effort.watch(page)
    page.goto(f"data:text/html,{quote(PAGE)}")

    def counted(*wanted):
        page.wait_for_timeout(50)
        assert (effort.keys, effort.clicks, effort.typed) == wanted

    page.locator("#text").fill("8")
    counted(0, 0, 1)
    page.locator("#number").fill("12")
    page.locator("#day").fill("1992-11-27")
    counted(0, 0, 13)
    page.locator("#text").press("a")
    page.keyboard.type("bc")
    counted(3, 0, 13)
    page.locator("#level").fill("60")
    page.locator("#of").select_option("b")
    page.locator("#on").check()
    page.get_by_role("button").click()
    counted(3, 5, 13)
    page.keyboard.press("Shift+Enter")
    counted(4, 5, 13)
    acts = 3 + 4 + 5  # fields, keys and clicks, none of which is the one before again
    seconds = acts * MENTAL_S + (13 + 4) * KEY_S + 5 * POINT_S + 2 * HAND_S
    assert effort.seconds == pytest.approx(seconds)
    context.close()


def test_a_flow_of_one_click():
    """For the test below."""
    EFFORT.acted("click", "")


def test_what_a_flow_costs_is_told_at_the_end_of_a_run():
    """Also where processes share the work."""
    this = f"{__file__}::{test_a_flow_of_one_click.__name__}"
    command = [sys.executable, "-m", "pytest", "-n", "2", "-p", "no:cacheprovider", this]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert f"0 keys, 1 clicks, 0 letters, {MENTAL_S + POINT_S:.0f} s predicted" in done.stdout, done.stdout
