"""Types of arrays are named in one place."""

import ast
from pathlib import Path

from kinemark.data import array_types

HERE = Path(array_types.__file__)


def named_types(path):
    """Of a module: text of a type → its name, of the names that stand for types of arrays."""
    assigned = (
        node for node in ast.parse(path.read_text("utf-8")).body if isinstance(node, ast.Assign | ast.AnnAssign)
    )
    named = [(ast.unparse(node.value), ast.unparse(getattr(node, "target", None) or node.targets[0]))
             for node in assigned if node.value is not None]  # fmt: skip
    return {text: name for text, name in named if text.startswith("NDArray[")}


def test_no_module_names_a_type_again():
    known = named_types(HERE)
    assert set(known.values()) == {"Floats", "Ints", "Bools", "GreyLevels"}
    others = (path for path in HERE.parents[1].rglob("*.py") if path != HERE)
    again = {path.name: found for path in others if (found := named_types(path).keys() & known.keys())}
    assert again == {}
