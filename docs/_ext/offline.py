"""Fails the build where a page would load something from the network: a script, a style, a font, an image, a frame."""

from __future__ import annotations

from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

LOADS = {"script": "src", "img": "src", "iframe": "src", "source": "src", "link": "href", "object": "data"}
"""Attributes that a browser follows by itself; the links that a reader clicks are not among them."""

HARMLESS = {"canonical", "license", "author", "search", "index", "next", "prev", "help"}
"""What a `link` may be without being fetched."""


class Loaded(HTMLParser):
    """Collects what a page loads from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.remote: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the address of a tag that loads something."""
        values = dict(attrs)
        if tag == "link" and (values.get("rel") or "") in HARMLESS:
            return
        address = values.get(LOADS.get(tag, "")) or ""
        if address.startswith(("http:", "https:", "//")):
            self.remote.append(address)


def remote(folder: Path) -> Iterator[str]:
    """Each address that a page or style sheet of the site loads from elsewhere."""
    for page in sorted(folder.rglob("*.html")):
        found = Loaded()
        found.feed(page.read_text(encoding="utf-8"))
        yield from (f"{page.relative_to(folder)} loads {address}" for address in found.remote)
    for sheet in sorted(folder.rglob("*.css")):
        text = sheet.read_text(encoding="utf-8").replace('"', "").replace("'", "")
        if "url(http" in text or "url(//" in text or "@import http" in text:
            yield f"{sheet.relative_to(folder)} loads from elsewhere"


def check(app: Sphinx, error: Exception | None) -> None:
    """Look through the finished site.

    Raises:
        ExtensionError: a page would load something from the network.
    """
    if error is None and app.builder.format == "html" and (found := list(remote(Path(app.outdir)))):
        raise ExtensionError("pages must work without a network:\n  " + "\n  ".join(found))


def setup(app: Sphinx) -> dict[str, bool]:
    """Check when the build is finished."""
    app.connect("build-finished", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
