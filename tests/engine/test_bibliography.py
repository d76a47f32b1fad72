"""The bibliography: one file, from which commands and pages are made."""

import re

import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError
from kinemark.engine.bibliography import as_bibtex, as_text, chosen, references


def test_every_work_has_a_line_and_an_entry_for_latex():
    found = references()
    assert len(as_text(found).splitlines()) == len(found) > 50
    keys = re.findall(r"^@\w+\{(\w+),$", as_bibtex(found), re.MULTILINE)
    assert sorted(keys) == sorted(found)
    assert as_bibtex(found).count("{") == as_bibtex(found).count("}")


def test_works_are_found_by_words():
    (key,) = chosen(["Swamidas"])
    assert references()[key]["year"] == 1997
    assert set(chosen(["woltring", "1986"])) < set(chosen(["woltring"])) | {key for key in references()}
    with pytest.raises(KinemarkError, match="No work holds"):
        chosen(["nobody wrote this"])


def test_the_command_lists_them(capsys):
    app(["cite", "Swamidas"], result_action="return_value")
    assert "Swamidas" in capsys.readouterr().out
    app(["cite", "Swamidas", "--bibtex"], result_action="return_value")
    assert capsys.readouterr().out.startswith("@")
