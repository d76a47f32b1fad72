"""Pages as a browser shows them: no complaint, no sideways scrolling, drawings on demand, markers that play."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from kinemark.data import Trial
from kinemark.engine.gait.files import gait_of_files
from kinemark.engine.gait.settings import GaitSettings
from kinemark.engine.gait.trial_files import SubjectFiles
from kinemark.fill import Linear, fill
from kinemark.findings.gaps import filling_figures
from kinemark.io.c3d import write_c3d
from kinemark.report import write_report
from kinemark.report.drawing_library import ASSETS, drawing_library, relink
from kinemark.report.filling_page import filling_page
from kinemark.synth import walking
from support.browser import opened
from support.captures import capture, judge, ring, walk
from support.many_tracks import long_trial
from support.pages import PAGES

LONG = "Participant_with_a_long_name_and_no_space_in_it:a_marker_that_has_a_long_name_too"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Every page, with long names, sharing a library; and a report in the folder of a trial."""
    folder = tmp_path_factory.mktemp("results")
    for name, make in PAGES.items():
        page = folder / f"{name}.html"
        page.write_text(make(LONG), encoding="utf-8")
        relink(page, folder / ASSETS, self_contained=False)
    rig = ring(6)
    records = capture(rig, walk(markers=6, frames=150))
    write_report(
        folder / "walk 01/report.html", quality=judge(rig, records), rig=rig, **records, assets=folder / ASSETS
    )
    return folder


@pytest.mark.parametrize(("name", "width"), [*((name, 400) for name in PAGES), ("gaps", 1366), ("sensitivity", 1366)])
def test_pages_are_drawn_without_complaint_and_do_not_scroll_sideways(folder, name, width):
    with opened(folder / f"{name}.html", width=width, height=768) as page:
        assert page.errors == []
        assert page.ask("document.documentElement.scrollWidth") <= width
        drawn = "[...document.querySelectorAll('.plot')].filter(place => !place.querySelector('.main-svg')).length"
        assert page.ask(drawn) == 0
        assert page.ask("document.getElementById('undrawn')?.hidden ?? true")


def test_a_table_of_gaps_with_words_in_three_columns_fits_its_page(tmp_path):
    """The reason that a gap is open, in the last column, was cut off."""
    xyz = walk(frames=120)
    xyz[0, 40:60] = xyz[1, 50:55] = np.nan
    before = capture(ring(), xyz, names=[f"Daphnee:MARK_{m}" for m in range(3)])["trajectories"]
    filled = fill(before, method=Linear(), limit_mm=np.inf)
    words = {"candidates": {"cubic + rigid_body + local_regression": 0.17}, "suspicious": (41,), "sd_mm": 35.0}
    first, other = (replace(gap, method="cubic + local_regression + body", **words) for gap in filled.gaps)
    filled = filled._replace(gaps=(replace(first, method="", state="sd_contradicts"), other))
    figures = filling_figures(filled, before, source="walk.c3d", method="auto", limit_mm=20.0)
    page = tmp_path / "gaps.html"
    page.write_text(filling_page(figures=figures, trajectories=filled.trajectories, before=before), encoding="utf-8")
    with opened(page, width=1366, height=768) as shown:
        assert shown.ask("document.querySelector('td:last-child').textContent").startswith("the largest standard")
        assert (
            shown.ask("Math.max(...[...document.querySelectorAll('.scroll')].map(e => e.scrollWidth - e.clientWidth))")
            == 0
        )


TITLES = """[...document.querySelectorAll('#kinematics-drawing .annotation-text')]
    .filter(one => /^(Pelvic|Hip|Knee|Ankle) .* \\(°\\)$/.test(one.textContent))
    .map(one => one.getBoundingClientRect()).map(box => [box.left, box.right, box.top])"""


def test_titles_of_panels_beside_each_other_stay_apart_where_the_page_is_narrow(tmp_path):
    subject = walking(duration_s=3.0, rate=100.0, seed=1)
    write_c3d(tmp_path / "walk.c3d", Trial("walk", subject.trajectories))
    found = gait_of_files(SubjectFiles([tmp_path / "walk.c3d"]), settings=GaitSettings(uncertainty=False))
    with opened(found.folder / "gait.html", width=400, height=768) as page:
        page.ask("document.getElementById('kinematics').scrollIntoView()")
        page.until(f"{TITLES}.length > 9")
        assert page.ask("document.documentElement.scrollWidth") <= 400
        rows = {}
        for left, right, top in page.ask(TITLES):
            rows.setdefault(round(top / 10), []).append((left, right))
        assert max(map(len, rows.values())) == 3
        for row in rows.values():
            assert all(a[1] + 4 < b[0] for a, b in pairwise(sorted(row)))


def test_legends_stay_below_the_titles_of_axes_where_the_page_is_narrow(folder):
    """So high a window shows the whole page, so that all is drawn."""
    with opened(folder / "walk 01/report.html", width=400, height=24_000) as page:
        page.until("document.querySelectorAll('.plot .legend').length > 3")
        covered = page.ask("""[...document.querySelectorAll('.plot')].filter(plot => {
            const box = of => plot.querySelector(of)?.getBoundingClientRect();
            const title = box('.g-xtitle'), key = box('.legend .bg');
            return title?.height && key && key.top < title.bottom && title.top < key.bottom;
        }).map(plot => plot.id)""")
        assert covered == []


def test_what_is_judged_first_of_a_gait_stands_on_the_first_page(tmp_path):
    subject = walking(duration_s=3.0, rate=100.0, seed=1)
    write_c3d(tmp_path / "walk.c3d", Trial("walk", subject.trajectories))
    found = gait_of_files(SubjectFiles([tmp_path / "walk.c3d"]), settings=GaitSettings(uncertainty=False))
    with opened(found.folder / "gait.html", width=703, height=1000) as page:
        page.send("Emulation.setEmulatedMedia", media="print")
        page_px = (297 - 12 - 15) / 25.4 * 96  # A4 less its margins
        assert page.ask("document.querySelector('#time').getBoundingClientRect().bottom") < page_px
        wrapped = "[...document.querySelectorAll('#keys tbody th')].filter(one => one.clientHeight > 24).length"
        assert page.ask(wrapped) == 0


@pytest.mark.parametrize("name", PAGES)
def test_pages_are_printed_within_the_margins_of_their_paper(folder, name):
    """As wide as A4 without its margins nothing is cut off, and no drawing or row of a table is divided."""
    with opened(folder / f"{name}.html", width=703, height=1000) as page:
        page.ask("dispatchEvent(new Event('beforeprint'))")
        page.send("Emulation.setEmulatedMedia", media="print")
        wide = "Math.max(0, ...[...document.querySelectorAll('.plot svg.main-svg')].map(one => one.clientWidth))"
        page.until(f"{wide} === 0 || {wide} === PRINTED")
        every = "[...document.querySelectorAll('.card, table, td, .plot, p')]"
        assert page.ask(f"Math.max(...{every}.map(one => one.getBoundingClientRect().right))") <= 703
        narrow = (
            "[...document.querySelectorAll('td.words')].map(one => one.getBoundingClientRect().width).filter(Boolean)"
        )
        assert page.ask(f"Math.min(999, ...{narrow})") > 60  # of 7 points; a sentence of one letter a line is not read
        divided = "one => getComputedStyle(one).breakInside !== 'avoid'"
        assert page.ask(f"[...document.querySelectorAll('.plot, tr')].filter({divided}).length") == 0


def test_a_page_in_a_folder_of_its_own_finds_the_library_and_plays(folder):
    with opened(folder / "walk 01/report.html") as page:
        dots = "document.getElementById('scene').data.at(-1)"
        page.until("!!document.querySelector('#scene + .controls')")
        began = page.ask(f"{dots}.name")
        shown = page.ask("document.querySelector('#scene + .controls output').textContent")
        assert began == f"markers at {shown}" != "markers at 0.00 s", "the slider stood at the beginning"
        page.ask("document.querySelector('#scene + .controls button').click()")
        page.until(f"{dots}.name !== {began!r}")
        assert page.ask("document.querySelector('#scene + .controls button').textContent") == "Pause"
        page.ask("document.querySelector('#scene + .controls button').click()")
        page.ask("(s => { s.value = 100; s.oninput(); })(document.querySelector('#scene + .controls input'))")
        page.until(f"{dots}.name === 'markers at 2.00 s'")
        assert page.ask(f"{dots}.x.length") == 6 and page.errors == []


def test_without_its_library_a_page_says_what_to_do(folder, tmp_path):
    alone = tmp_path / "report.html"
    alone.write_bytes((folder / "report.html").read_bytes())
    with opened(alone) as page:
        page.until("!document.getElementById('undrawn').hidden")
        assert "--self-contained" in page.ask("document.getElementById('undrawn').innerText")
    relink(alone, tmp_path / ASSETS, self_contained=True)
    (tmp_path / ASSETS).mkdir(exist_ok=True)
    with opened(alone) as page:
        assert page.ask("document.querySelectorAll('.main-svg').length") > 0 and page.errors == []


def test_a_trial_of_a_thousand_tracks_loads_at_once_and_is_not_endless(tmp_path):
    write_report(tmp_path / "report.html", **long_trial(1000, 1000), assets=tmp_path / ASSETS)
    with opened(tmp_path / "report.html", drawn=False) as page:
        seconds = page.ask("performance.getEntriesByType('navigation')[0].loadEventEnd") / 1000
        assert seconds < 2.0
        assert page.ask("document.documentElement.scrollHeight") < 16_000
        shown = "document.querySelectorAll('tbody:not([hidden]) tr').length"
        folded = page.ask(shown)
        page.ask("document.querySelector('.unfold button').click()")
        assert page.ask(shown) > folded


def test_pages_print_with_their_drawings(folder):
    with opened(folder / "walk 01/report.html") as page:
        told = page.send("Page.printToPDF", printBackground=True)["data"]
        assert len(told) > 100_000
        assert page.errors == []


def test_the_library_is_left_alone_until_something_is_drawn(tmp_path):
    library = drawing_library(tmp_path / "page.html", tmp_path / ASSETS)
    assert not re.match("https?:", library.address)


CONTRASTS = """
(() => {  // of every text with the ground behind it, by WCAG 2.2: [ratio, text]
  const parts = text => { const p = text.match(/[\\d.]+/g).map(Number); return p.length < 4 ? [...p, 1] : p; };
  const linear = v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const lit = rgb => { const [r, g, b] = rgb.slice(0, 3).map(v => linear(v / 255));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const ground = e => { for (; e; e = e.parentElement) {
    const p = parts(getComputedStyle(e).backgroundColor); if (p[3] > 0.5) return p; } return [255, 255, 255, 1]; };
  const found = [];
  for (const e of document.querySelectorAll("body *")) {
    const own = [...e.childNodes].filter(n => n.nodeType === 3).map(n => n.data.trim()).join("");
    const hidden = !e.getClientRects().length || e.matches("script, style, option, .modebar *");
    if (hidden || !/[\\p{L}\\d]/u.test(own)) continue;
    const style = getComputedStyle(e), svg = e instanceof SVGElement, ink = parts(svg ? style.fill : style.color);
    if (svg && +style.fillOpacity === 0) continue;
    const [a, b] = [lit(ink), lit(ground(e))];
    found.push([(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), own.slice(0, 40)]);
  }
  return found;
})()
"""


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_every_text_can_be_read_in_both_themes(folder, name, dark):
    with opened(folder / f"{name}.html", dark=dark) as page:
        assert (page.ask("getComputedStyle(document.body).backgroundColor") == "rgb(20, 27, 33)") == dark
        faint = [(round(ratio, 2), text) for ratio, text in page.ask(CONTRASTS) if ratio < 4.5]
        assert faint == [] and page.errors == []


def test_a_page_changes_its_theme_while_it_is_open_and_prints_light(folder):
    grounds = "[...document.querySelectorAll('.plot')].map(place => place.layout.paper_bgcolor)"
    with opened(folder / "walk 01/report.html", dark=True) as page:
        assert set(page.ask(grounds)) == {"#1d262e"}
        page.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "light"}])
        page.until(f"{grounds}.every(ground => ground === '#FFFFFF')")
        assert page.errors == []
