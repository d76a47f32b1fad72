"""Names that are stated of tracks: both kinds of file say the same, and what is no statement is refused."""

import pytest

from kinemark.data import KinemarkError
from kinemark.io.track_names import TrackName, read_track_names

SAID = (TrackName("*1", "LASI"), TrackName("*7", None), TrackName("*3", "LKNE", 1, 120), TrackName("*3", "LTIB", 121))


def test_both_kinds_of_file_say_the_same(tmp_path):
    toml, table = tmp_path / "names.toml", tmp_path / "names.csv"
    toml.write_text(
        '[names]\n"*1" = "LASI"\n"*7" = false\n'
        '"*3" = [{ name = "LKNE", first = 1, last = 120 }, { name = "LTIB", first = 121 }]\n'
    )
    table.write_text("track,name,first,last\n*1,LASI,,\n*7,,,\n\n*3,LKNE,1,120\n*3, LTIB ,121,\n")
    assert read_track_names(toml) == read_track_names(table) == SAID
    (tmp_path / "short.csv").write_text("track,name\n*1,LASI\n*7,\n")
    assert read_track_names(tmp_path / "short.csv") == SAID[:2]


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("a.txt", "x", "endings .toml, .csv"),
        ("a.csv", "marker,track\n", "Wanted are the columns track,name,first,last"),
        ("a.csv", "track,name\n*1\n", "line 2: has 1 cells"),
        ("a.csv", "track,name\n*1,LASI,3\n", "line 2: has 3 cells"),
        ("a.csv", "track,name,first\n*1,LASI,x\n", "line 2: .*'x'"),
        ("a.csv", "track,name,first,last\n*1,LASI,9,3\n", "line 2: .*9 to 3"),
        ("a.csv", "track,name,first\n*1,LASI,0\n", "from 1"),
        ("a.csv", "track,name\n,LASI\n", "no track"),
        ("a.csv", "track,name\n*1,LASI\n*1,RASI\n", "both LASI and RASI"),
        ("a.csv", "track,name,first,last\n*1,LASI,1,10\n*1,,10,\n", "both LASI and no marker"),
        ("a.toml", "names = 3", "one table"),
        ("a.toml", "[names]\na = 3", "wanted text, or false"),
        ("a.toml", "[names]\na = true", "wanted text, or false"),
        ("a.toml", '[names]\na = { nam = "x" }', "unknown key 'nam'"),
        ("a.toml", '[names]\na = { name = "x", first = 1.5 }', "whole numbers"),
        ("a.toml", "[names", "no TOML"),
    ],
)
def test_what_is_no_statement_is_refused(name, text, says, tmp_path):
    (tmp_path / name).write_text(text)
    with pytest.raises(KinemarkError, match=says):
        read_track_names(tmp_path / name)
