"""A command line that lacks something says what, and what that is."""

import pytest

from kinemark.apps.cli import app


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (["fill"], "kinemark fill wants SOURCE: a file of trajectories"),
        (["convert", "a.c3d"], "kinemark convert wants TARGET: the file to write"),
        (["angles", "a.c3d"], "kinemark angles wants --model: um2as, isb_upper_limb, isb_shoulder, or a TOML file"),
        (["angles", "a.c3d", "--model"], "kinemark angles: --model wants a value."),
        (["marker-set", "show"], "kinemark marker-set show wants NAME"),
        (["run", "x", "--sett", "y"], "Did you mean --set?"),
        (["gait", "x", "--emg-to", "y"], 'Choose from: "trial", "strides"'),
    ],
)
def test_what_is_missing_is_named_as_the_help_names_it(typed, said, capsys):
    with pytest.raises(SystemExit) as ended:
        app(typed)
    words = " ".join(capsys.readouterr().err.split())
    assert ended.value.code == 2 and said in words
    command = " ".join(["kinemark", *(typed[:2] if typed[0] == "marker-set" else typed[:1])])
    assert words.endswith(f"What there is: {command} --help")
