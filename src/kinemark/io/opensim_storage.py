"""OpenSim's tables of numbers over time, `.mot` and `.sto`: a heading, names between tabs, then rows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from .files import write_text


def write_storage(path: Path | str, columns: Mapping[str, Floats], *, rate: float, in_degrees: bool = False) -> None:
    """Write columns (F) by name, at `rate` Hz from time 0; a missing value is NaN.

    Raises:
        KinemarkError: the columns are not of one length, or the file cannot be written.
    """
    path = Path(path)
    lengths = {len(column) for column in columns.values()}
    if len(lengths) != 1:
        raise KinemarkError(f"{path.name}: columns of {sorted(lengths)} rows, wanted one length.")
    (n,) = lengths
    head = [path.stem, "version=1", f"nRows={n}", f"nColumns={len(columns) + 1}"]
    head += [f"inDegrees={'yes' if in_degrees else 'no'}", "endheader", "\t".join(["time", *columns])]
    rows = np.column_stack([np.arange(n) / rate, *columns.values()])
    text = "\n".join("\t".join(f"{value:.8g}" for value in row) for row in rows)
    write_text(path, "\n".join(head) + "\n" + text + "\n")
