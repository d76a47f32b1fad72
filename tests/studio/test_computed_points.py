"""A file with axes of segments and joint centres, as other programs leave it: markers alone are shown until asked."""

import re

from kinemark.data import Trial
from kinemark.io.trial import write_trial
from support.computed import computed, walker, with_computed
from support.studio_page import Studio, served, window


def test_computed_points_are_put_aside_told_and_shown_by_a_key(tmp_path, chromium_running):
    markers = walker()
    write_trial(Trial("walk", with_computed(markers)), tmp_path / "walk.c3d")
    n, away = len(markers), sorted(computed(markers))
    with served(tmp_path) as server:
        studio = Studio(window(chromium_running), server).enter(server.address)
        page = studio.open(trial="walk.c3d").page
        button = page.get_by_role("button", name=re.compile(f"Show {len(away)} computed points"))
        button.wait_for()
        named = []
        for _ in range(n):
            named += studio.press(".").page.locator("[aria-label=Selection] b").all_inner_texts()
        assert len({*named}) == n and not {*named} & {*away}
        page.get_by_role("button", name=re.compile("^Labels")).click()
        rows = page.locator("[aria-label='Names of tracks'] [data-track]")
        rows.first.wait_for()
        assert rows.count() == n
        studio.press("j")
        page.locator(f"[data-track={away[0]}]").wait_for()
        assert rows.count() == n + len(away)
        studio.press("j")
        page.locator(f"[data-track={away[0]}]").wait_for(state="detached")
        assert studio.errors == []
        page.context.close()
