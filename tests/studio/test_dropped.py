"""A file that is dropped on Home is opened, and what is to be said of it is seen there."""

import numpy as np

from kinemark.io.trc import write_trc
from support.studio_page import Studio, served, window
from support.walked import clean, spiked


def test_a_dropped_file_is_audited_and_what_was_said_of_it_stays(tmp_path, chromium_running):
    (tmp_path / "files").mkdir()
    write_trc(tmp_path / "walk.trc", spiked(clean(), 6, 100, 103))
    before = (tmp_path / "walk.trc").read_bytes()
    with served(tmp_path / "files") as server:
        studio = Studio(window(chromium_running), server).enter(server.address)
        page = studio.page
        page.locator("input[type=file]").set_input_files(tmp_path / "walk.trc")
        page.locator("main[data-screen=tracks][data-frame]").wait_for()
        page.get_by_text("Errors expected").first.wait_for()
        studio.idle().press("n")
        page.get_by_text("jumps away and back, frames 101–103").first.wait_for()
        assert studio.note().startswith("walk.trc is there")
        assert (tmp_path / "walk.trc").read_bytes() == before
        broken = {"name": "broken.c3d", "mimeType": "", "buffer": np.zeros(600, np.uint8).tobytes()}
        studio.press("Alt+Shift+H").page.locator("main[data-screen=home]").wait_for()
        page.locator("input[type=file]").set_input_files([broken])
        page.locator("footer [data-note=refused]").get_by_text("broken.c3d").wait_for()
        kept = [path.name for path in (tmp_path / "files" / "dropped").iterdir()]
        assert kept == ["walk.trc"]
        page.context.close()
