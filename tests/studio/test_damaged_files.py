"""Files that hold nothing that can be shown: told why on Home and on every screen, and nothing is offered in vain."""

import re

from kinemark.data import Trial
from kinemark.io.trial import write_trial
from support.computed import walker
from support.studio_page import Studio, served, window


def test_a_file_that_cannot_be_read_is_told_and_is_not_run(tmp_path, chromium_running):
    write_trial(Trial("walk", walker()), tmp_path / "walk.c3d")
    whole = (tmp_path / "walk.c3d").read_bytes()
    (tmp_path / "cut.c3d").write_bytes(whole[:700])
    with served(tmp_path) as server:
        studio = Studio(window(chromium_running), server).enter(server.address)
        page = studio.page
        row = page.get_by_role("row", name=re.compile(r"^cut\.c3d"))
        row.get_by_text("not readable").wait_for()
        assert "cut.c3d" in row.locator("small").inner_text()
        page.get_by_role("button", name="cut.c3d", exact=True).click()
        page.get_by_role("heading", name="This file cannot be shown").wait_for()
        assert page.get_by_role("button", name=re.compile("^Run")).count() == 0
        assert "run the trial" not in page.locator("footer").inner_text()
        steps = page.get_by_role("navigation", name="Steps")
        assert not steps.get_by_role("button", name="Detect").is_enabled()
        page.get_by_role("button", name="Home").last.click()
        page.get_by_role("button", name="walk.c3d", exact=True).click()
        page.locator("main[data-screen=tracks][data-frame]").wait_for()
        assert not steps.get_by_role("button", name="Digitise").is_enabled()
        assert steps.get_by_role("button", name="Labels").is_enabled()
        assert studio.errors == []
        page.context.close()
