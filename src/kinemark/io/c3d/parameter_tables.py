"""Parameters that hold one row for each point, channel or event, continued beyond 255 rows in NAME2, NAME3, …

Rows that do not change are left as they stand in the file, byte for byte.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...data.array_types import Floats
from .document import C3D, with_parameters
from .parameters import Parameter, ValueArray

MOST_ROWS = 255  # of one parameter: dimensions are bytes; of the format
LONGEST = 127  # bytes of a text; of the format


def text_rows(doc: C3D, group: str, name: str) -> list[bytes]:
    """The rows of a text parameter and its continuations, with their padding."""
    parameters = [p for p in doc.series(group, name) if p.is_text and p.values.ndim]
    return [row.tobytes() for p in parameters for row in p.values.reshape(len(p.texts), p.values.shape[-1])]


def with_text(doc: C3D, group: str, name: str, texts: Sequence[str], source: Sequence[int], had: Sequence[str]) -> C3D:
    """The document with these texts, one a row.

    Args:
        doc: the document.
        group, name: which parameter.
        texts: the new rows.
        source: row of the document that each comes from, −1 for none.
        had: what the document's rows say; a row that says the same keeps its bytes.
    """
    old = text_rows(doc, group, name)
    if list(texts) == list(had) and list(source) == list(range(len(had))):
        return doc
    kept = [0 <= s < min(len(old), len(had)) and had[s] == text for s, text in zip(source, texts, strict=True)]
    fresh = cut_texts(texts)
    rows = [old[s] if keep else fresh[k] for k, (s, keep) in enumerate(zip(source, kept, strict=True))]
    width = max(map(len, rows), default=0)
    table = np.frombuffer(b"".join(row.ljust(width) for row in rows), np.uint8).reshape(len(rows), width)
    return _with_rows(doc, group, name, table)


def with_descriptions(doc: C3D, group: str, rows: Sequence[int], count: int) -> C3D:
    """The document with the descriptions of its `count` points or channels in the order of their new rows."""
    if doc.get(group, "DESCRIPTIONS") is None or list(rows) == list(range(count)):
        return doc
    had = (*doc.texts(group, "DESCRIPTIONS"), *[""] * count)[:count]
    return with_text(doc, group, "DESCRIPTIONS", [had[r] if r >= 0 else "" for r in rows], rows, had)


def cut_texts(texts: Sequence[str]) -> list[bytes]:
    """In UTF-8, cut between letters at 127 bytes; what differs only behind that ends in ~2, ~3, …"""
    rows = [_cut(text, LONGEST) for text in texts]
    taken = {row for row, text in zip(rows, texts, strict=True) if not too_long(text)}
    for k, text in enumerate(texts):
        if too_long(text):
            number = 1
            while rows[k] in taken:
                number += 1
                tail = f"~{number}".encode()
                rows[k] = _cut(text, LONGEST - len(tail)) + tail
            taken.add(rows[k])
    return rows


def too_long(text: str) -> bool:
    """Whether a row of a C3D file has no room for a text."""
    return len(text.encode("utf-8")) > LONGEST


def _cut(text: str, most: int) -> bytes:
    """UTF-8, cut between letters at so many bytes."""
    return text.encode("utf-8")[:most].decode("utf-8", "ignore").encode("utf-8")


def with_numbers(doc: C3D, group: str, name: str, values: ArrayLike, *, whole: bool = False) -> C3D:
    """The document with these numbers, one row each along the first axis; integers where `whole` and the file agree."""
    table = np.asarray(values, np.float64)
    old, there = doc.numbers(group, name), doc.get(group, name)
    if old.size == table.size and (old == table.astype(np.float32).reshape(-1)).all():
        return doc
    if whole and (there is None or there.values.dtype != np.float32):
        return _with_rows(doc, group, name, Parameter.whole(name, table).values)
    return _with_rows(doc, group, name, table.astype(np.float32))


def matched(names: Sequence[str], old: Sequence[str]) -> list[int]:
    """For each name the row of the first of the old ones that is the same and not yet taken; −1 for none."""
    free: dict[str, list[int]] = {}
    for i in reversed(range(len(old))):
        free.setdefault(old[i], []).append(i)
    return [free[name].pop() if free.get(name) else -1 for name in names]


def rows_from(values: Floats, source: Sequence[int], fresh: float) -> Floats:
    """Entries of a column picked by row; `fresh` where there is none."""
    extended = np.append(values, fresh)
    return extended[[s if 0 <= s < len(values) else len(values) for s in source]]


def _with_rows(doc: C3D, group: str, name: str, table: ValueArray) -> C3D:
    count = max(len(doc.series(group, name)), -(-len(table) // MOST_ROWS), 1)
    parts = [table[i * MOST_ROWS : (i + 1) * MOST_ROWS] for i in range(count)]
    names = [name, *(f"{name}{i}" for i in range(2, count + 1))]
    return with_parameters(doc, group, [Parameter(n, part) for n, part in zip(names, parts, strict=True)])
