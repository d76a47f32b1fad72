"""A command line that lacks something says what, and what that is; the help says of every option what it is."""

import re

import pytest

from kinemark.apps.cli import app


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (["fill"], "kinemark fill wants SOURCE: a file of trajectories"),
        (["convert", "a.c3d"], "kinemark convert wants TARGET: the file to write"),
        (["gait-compare", "a", "b"], "kinemark gait-compare wants --output: folder of the results."),
        (["angles", "a.c3d", "--model"], "kinemark angles: --model wants a value."),
        (["marker-set", "show"], "kinemark marker-set show wants NAME"),
        (["edits", "erase"], "kinemark edits erase wants TRIAL: SESSION/NAME or a file."),
        (["run", "x", "--sett", "y"], "Did you mean --set?"),
        (["gait", "x", "--emg-to", "y"], 'Choose from: "trial", "strides"'),
    ],
)
def test_what_is_missing_is_named_as_the_help_names_it(typed, said, capsys):
    with pytest.raises(SystemExit) as ended:
        app(typed)
    words = " ".join(capsys.readouterr().err.split())
    assert ended.value.code == 2 and said in words
    command = " ".join(["kinemark", *(typed[:2] if typed[0] in ("marker-set", "edits") else typed[:1])])
    assert words.endswith(f"What there is: {command} --help")


def test_help_says_of_every_option_what_it_is():
    """A line of a docstring with two names in it gave one option the words of both, and the other none."""
    said = app.generate_docs(output_format="markdown", heading_level=1)
    options = re.findall(r"(?m)^\* `(.+?)`: ?(.*)$", said)
    assert len(options) > 250
    assert [name for name, words in options if not words or words.startswith(("**[", "*["))] == []
    assert [name for name, _ in options if "--empty-" in name] == []
