"""Keys are made of content: equal things have one key, and things that differ anywhere have two."""

import dataclasses
from enum import IntEnum
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinemark.data.method import plain_parameters
from kinemark.engine import keys
from kinemark.engine.keys import code_key, digest, file_key
from kinemark.engine.store import Store

PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False)
    | st.text(max_size=5)
    | st.binary(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.tuples(inner, inner) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=8,
)


@dataclasses.dataclass(frozen=True)
class Method:
    """A method that holds an array."""

    gate: float
    template: np.ndarray


class Side(IntEnum):
    LEFT = 0


def same(a, b):
    """Equal in kind and content; −0.0 and 0.0 are two."""
    return repr(a) == repr(b)


@given(PLAIN, PLAIN)
def test_two_values_have_one_key_only_where_they_are_the_same(a, b):
    assert (digest(a) == digest(b)) == same(a, b)


def test_nesting_counts():
    assert len({digest([1, [2, 3]]), digest([[1, 2], 3]), digest([1, 2, 3]), digest([1], [2, 3]), digest("123")}) == 5


def test_arrays_count_whole_wherever_they_are():
    """NumPy's text of 5 000 numbers leaves most of them out."""
    one = np.arange(5000.0)
    other = one.copy()
    other[2500] += 1e-9
    for hold in (lambda a: a, lambda a: [a], lambda a: {"a": (a, 1)}, lambda a: Method(3.0, a)):
        assert digest(hold(one)) != digest(hold(other))
        assert digest(hold(one)) == digest(hold(one.copy()))
    assert digest(one) != digest(one.astype(np.float32)) and digest(one) != digest(one.reshape(2, -1))


def test_what_has_no_known_content_has_no_key():
    for value in (object(), lambda: 0, np.array([object()]), iter([1])):
        with pytest.raises(TypeError, match="key"):
            digest(value)


def test_order_counts_where_it_means_something():
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest({1, 2, 3}) == digest({3, 2, 1})
    assert digest([1, 2]) != digest([2, 1])
    assert digest(Side.LEFT) != digest(0) and digest(Path("a")) != digest("a")


def test_files_are_known_by_what_is_in_them(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("1")
    before = file_key(file)
    file.write_text("2")
    assert file_key(file) != before
    file.write_text("1")
    assert file_key(file) == before  # whenever it was written
    file.unlink()
    assert file_key(file) not in (before, file_key())


def test_large_files_are_known_by_parts_of_them(tmp_path, monkeypatch):
    monkeypatch.setattr(keys, "WHOLE", 1000)
    file = tmp_path / "a.avi"
    file.write_bytes(bytes(200_000))
    before = file_key(file)
    with file.open("r+b") as open_file:
        open_file.seek(150_000)
        open_file.write(b"x")
    assert file_key(file) != before


def test_the_packages_own_sources_count(tmp_path):
    class Folder:
        def __init__(self, path):
            self.path, self.name = path, path.name

        def iterdir(self):
            return [Folder(p) for p in self.path.iterdir()]

        def is_dir(self):
            return self.path.is_dir()

        def read_bytes(self):
            return self.path.read_bytes()

    (tmp_path / "stage").mkdir()
    (tmp_path / "stage/a.py").write_text("x = 1")
    before = keys._sources(Folder(tmp_path), "")
    (tmp_path / "stage/a.py").write_text("x = 2")
    assert keys._sources(Folder(tmp_path), "") != before
    assert len(code_key()) == 16 and code_key() == code_key()


def test_the_page_of_the_studio_does_not_count(tmp_path):
    """Building it again makes no result stale."""
    page = tmp_path / "apps" / "studio" / "page"
    page.mkdir(parents=True)
    before = keys._sources(tmp_path, "")
    (page / "index.html").write_text("<!doctype html>")
    assert keys._sources(tmp_path, "") == before
    (page.parent / "app.py").write_text("x = 1")
    assert keys._sources(tmp_path, "") != before


def test_an_update_never_serves_what_another_version_made(tmp_path, monkeypatch):
    from kinemark.engine.graph import Graph, Stage
    from kinemark.engine.progress import SILENT

    def save(path, record):
        path.parent.mkdir(exist_ok=True)
        path.write_text(record)

    graph = Graph((Stage("one", (), ("one.txt",), lambda inputs, _: inputs, save, Path.read_text),))
    for version, wanted in (("a", ["one"]), ("a", []), ("b", ["one"])):
        monkeypatch.setattr("kinemark.engine.graph.code_key", lambda version=version: version)
        with Store.open(tmp_path / "r", tmp_path / "lock", SILENT.of("wait")) as store:
            graph.run("one", version, store, SILENT)
            assert store.computed == wanted


def test_a_method_that_holds_an_array_can_be_written_down():
    import json

    said = json.loads(json.dumps(plain_parameters(Method(3.0, np.arange(6.0).reshape(2, 3)))))
    assert said["gate"] == 3.0 and said["template"]["shape"] == [2, 3]
    assert said != plain_parameters(Method(3.0, np.zeros((2, 3))))
