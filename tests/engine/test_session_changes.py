"""Changes of session.toml in places."""

import pytest

from kinemark.data import KinemarkError
from kinemark.engine.session_changes import change_session
from kinemark.engine.settings import read_settings

TEXT = """name = "a"
# x ä
[cameras]
names = ["a", "b"]
[calibration]
file = "rig.toml"
[[trials]]
name = "t"
detections = "x.csv"
"""


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_lines_end_as_they_did(tmp_path, end):
    file = tmp_path / "session.toml"
    file.write_bytes(TEXT.replace("\n", end).encode())
    for year in (2025, 2026):
        change_session(tmp_path, {("date",): f"{year}-01-02", ("subject",): "anna"})
    found = file.read_bytes().decode()
    lines = found.split(end)
    assert "\r" not in "".join(lines) and "\n" not in "".join(lines)
    assert [line for line in lines if line and "2026" not in line][:2] == TEXT.splitlines()[:2]
    assert str(read_settings(file).date) == "2026-01-02"


def test_what_would_not_be_understood_changes_nothing(tmp_path):
    file = tmp_path / "session.toml"
    file.write_text(TEXT, "utf-8")
    with pytest.raises(KinemarkError, match=r"session\.toml"):
        change_session(tmp_path, {("date",): "yesterday"})
    assert file.read_text("utf-8") == TEXT and [path.name for path in tmp_path.iterdir()] == ["session.toml"]
