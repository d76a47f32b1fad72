"""A component angle model as text, comma-separated: the segments, and then their angles over percent of the cycle.

    kinemark angle model,1
    period_s,1.08
    segment,from,to,bank,length_mm,spread_mm
    0,hip,knee,0,402.1,3.2
    …
    segment,percent,x_deg,y_deg,z_deg,cycles,xx,xy,xz,yy,yz,zz
    0,0,88.1,91.0,178.7,3,0.0004,…

x_deg, y_deg, z_deg are the angles with the axes (Swamidas 1997, 3.35); xx … zz the covariance of the direction's
cosines, empty where one cycle only was seen. Each segment has as many rows as the others, at equal steps of the cycle
from 0 on.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ..data import AngleModel, KinemarkError
from ..data.array_types import Floats, Ints
from .csv_table import write_table
from .number_text import bad_line, numbers, plain, read_text, whole

FIRST = ["kinemark angle model", "1"]
SEGMENTS = ["segment", "from", "to", "bank", "length_mm", "spread_mm"]
ANGLES = ["segment", "percent", "x_deg", "y_deg", "z_deg", "cycles", "xx", "xy", "xz", "yy", "yz", "zz"]

UPPER = np.triu_indices(3)  # entries of a symmetric matrix in the file; of the format, ours
UNIT = 0.01
"""By which the cosines of three angles may miss a unit vector; chosen."""


def write_angle_model(path: Path | str, model: AngleModel) -> None:
    """The model as a file, to be read by `read_angle_model`.

    Raises:
        KinemarkError: the file cannot be written.
    """
    rows: list[list[str]] = [["period_s", plain(model.period)], SEGMENTS]
    for s, (a, b) in enumerate(model.links):
        sizes = [plain(model.length[s]), plain(model.spread[s])]
        rows.append([str(s), model.names[a], model.names[b], str(model.bank[s]), *sizes])
    rows.append(ANGLES)
    steps = model.direction.shape[1]
    for s in range(len(model.links)):
        for k in range(steps):
            angles = [plain(value) for value in model.angles[s, k]]
            cov = [plain(value) for value in model.cov[s, k][UPPER]]
            rows.append([str(s), plain(100 * k / steps), *angles, str(model.cycles[s, k]), *cov])
    write_table(path, FIRST, rows)


def read_angle_model(path: Path | str) -> AngleModel:
    """The model in a file.

    Raises:
        KinemarkError: absent, or no such file; the message names the line.
    """
    rows = [(n, row) for n, row in enumerate(csv.reader(read_text(path).splitlines()), 1) if any(row)]
    cells = [[cell.strip() for cell in row] for _, row in rows]
    lines = [n for n, _ in rows]
    if len(cells) < 4 or cells[0][:2] != FIRST or cells[1][:1] != ["period_s"] or cells[2] != SEGMENTS:
        raise KinemarkError(f"{path} is no angle model: its first lines must be those that Kinemark writes.")
    if ANGLES not in cells:
        raise KinemarkError(f"{path} has no line {','.join(ANGLES)}, so it holds no angles.")
    cut = cells.index(ANGLES)
    pairs = [row[1:3] for row in cells[3:cut]]
    if not pairs or any(len(pair) < 2 or not all(pair) for pair in pairs):
        raise KinemarkError(f"{path} must name two markers for every segment.")
    period = numbers(path, lines[1:2], [cells[1][1:]], 1)[0, 0]
    sizes = numbers(path, lines[3:cut], [row[:1] + row[3:] for row in cells[3:cut]], 4)
    table = numbers(path, lines[cut + 1 :], cells[cut + 1 :], len(ANGLES))
    _check_order(path, sizes[:, 0], table[:, 0])
    bank = whole(path, lines[3:cut], sizes[:, 1], "bank")
    cycles = whole(path, lines[cut + 1 :], table[:, 5], "cycles")
    try:
        return _built(
            pairs, sizes, bank, _directions(path, lines[cut + 1 :], table), table[:, 6:], cycles, float(period)
        )
    except ValueError as error:
        raise KinemarkError(f"{path}: {error}.") from None


def _check_order(path: Path | str, segments: Floats, rows: Floats) -> None:
    """Segments count from 0, and each has equally many rows."""
    n = len(segments)
    steps = len(rows) // n
    if (
        steps < 4
        or not np.array_equal(segments, np.arange(n))
        or not np.array_equal(rows, np.repeat(np.arange(n), steps))
    ):
        raise KinemarkError(f"{path}: every segment must have the same number of rows, four or more, in order from 0.")


def _built(
    pairs: list[list[str]], sizes: Floats, bank: Ints, direction: Floats, upper: Floats, cycles: Ints, period: float
) -> AngleModel:
    names = tuple(dict.fromkeys(name for pair in pairs for name in pair))
    place = {name: m for m, name in enumerate(names)}
    links = np.array([[place[a], place[b]] for a, b in pairs], np.int64)
    s = len(links)
    return AngleModel(
        names, links, bank, sizes[:, 2], sizes[:, 3], direction.reshape(s, -1, 3),
        _covariances(upper).reshape(s, -1, 3, 3), cycles.reshape(s, -1), period,
    )  # fmt: skip


def _directions(path: Path | str, lines: list[int], table: Floats) -> Floats:
    """Unit vectors (N, 3) of angles."""
    cosine = np.cos(np.radians(table[:, 2:5]))
    size = np.linalg.norm(cosine, axis=1)
    wrong = ~(np.abs(size - 1) < UNIT)
    if wrong.any():
        k = int(np.flatnonzero(wrong)[0])
        raise bad_line(path, lines[k], "these three angles with the axes are not those of one direction")
    return np.asarray(cosine / size[:, None])


def _covariances(upper: Floats) -> Floats:
    """(N, 3, 3) of their upper parts (N, 6)."""
    cov = np.zeros((len(upper), 3, 3))
    cov[:, *UPPER] = upper
    cov.swapaxes(1, 2)[:, *UPPER] = upper
    return cov
