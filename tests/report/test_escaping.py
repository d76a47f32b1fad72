"""Names from outside are text on every page: in its markup, in the data of its scripts, and in what Plotly draws."""

from html.parser import HTMLParser

import pytest
from jinja2 import UndefinedError

from kinemark.report.drawing_library import inside
from kinemark.report.templating import environment, render
from support.pages import PAGES, data_of, raw_data_of, texts

EVIL = "<script>alert(1)</script>&\"'</script><img src=x onerror=alert(1)>{{ 7 * 7 }}"


class Parsed(HTMLParser):
    """What a browser makes of a page: its elements, attributes and plain text."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.attributes, self.text, self.scripts = [], [], [], 0
        self.feed(html.replace(inside().text, ""))

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [name for name, _ in attrs]

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module", params=PAGES)
def pages(request):
    """A page whose every name is markup, and the same page with a plain name."""
    make = PAGES[request.param]
    return make(EVIL), make("plain")


def test_names_make_no_element_and_no_attribute(pages):
    evil, plain = map(Parsed, pages)
    assert evil.tags == plain.tags
    assert not [name for name in evil.attributes if name.startswith("on")]
    assert EVIL in "".join(evil.text)  # it is shown, letter for letter


def test_names_in_scripts_cannot_end_them(pages):
    evil, plain = map(data_of, pages)
    assert evil.keys() == plain.keys()
    assert not [place for place, text in raw_data_of(pages[0]).items() if "<" in text or "&" in text]


def test_plotly_is_given_no_markup_from_outside(pages):
    drawn = {place: value for place, value in data_of(pages[0]).items() if place != "stick-data"}  # drawn on a canvas
    told = [text for value in drawn.values() for text in texts(value)]
    assert not [text for text in told if "<script" in text or "<img" in text]


def test_escaping_that_is_off_would_be_seen(monkeypatch):
    """The tests above can fail: without autoescape the same page is full of scripts."""
    loose = environment().overlay(autoescape=False)
    monkeypatch.setattr("kinemark.report.templating.environment", lambda: loose)
    evil, plain = (Parsed(PAGES["gaps"](name)) for name in (EVIL, "plain"))
    assert evil.tags != plain.tags


def test_a_name_that_is_missing_is_an_error():
    assert environment().autoescape is True
    with pytest.raises(UndefinedError):
        render("library.html")
