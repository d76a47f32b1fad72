"""Tables as TOML, to the letter as tomlkit writes them."""

import tomllib

import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from kinemark.io.toml_tables import tables_text
from support.examples import examples

NUMBERS = st.floats() | st.integers(-(2**63), 2**63 - 1)
VALUES = st.recursive(NUMBERS | st.booleans() | st.text(), lambda inner: st.lists(inner, max_size=3), max_leaves=6)
TABLES = st.recursive(VALUES, lambda inner: st.dictionaries(st.text(min_size=1), inner, max_size=3), max_leaves=9)


@settings(max_examples=examples(25))
@given(st.dictionaries(st.text(min_size=1), TABLES, max_size=4))
def test_tables_are_those_of_tomlkit(table):
    assert tables_text(table) == tomlkit.dumps(table)
    assert repr(tomllib.loads(tables_text(table))) == repr(tomllib.loads(tomlkit.dumps(table)))
