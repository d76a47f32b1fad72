"""Numbers of an .xls file (BIFF8 in an OLE2 container), as far as tests read them."""

import struct

END = 0xFFFFFFF0
"""Of a chain of sectors: from here on a number is no sector."""
SHEET, NUMBER, RK, MANY_RK, FORMULA = 0x809, 0x203, 0x27E, 0xBD, 0x06


def numbers(path):
    """(sheet, row, column) → number, all counted from 0; formulas with the value that was kept of them."""
    found, sheet, at, book = {}, -2, 0, _workbook(path.read_bytes())  # the first stream describes the book
    while at + 4 <= len(book):
        kind, size = struct.unpack_from("<HH", book, at)
        body, at = book[at + 4 : at + 4 + size], at + 4 + size
        if kind == SHEET:
            sheet += 1
        elif kind in (NUMBER, FORMULA):
            row, column = struct.unpack_from("<HH", body)
            found[sheet, row, column] = struct.unpack_from("<d", body, 6)[0]
        elif kind == RK:
            row, column = struct.unpack_from("<HH", body)
            found[sheet, row, column] = _short(struct.unpack_from("<I", body, 6)[0])
        elif kind == MANY_RK:
            row, column = struct.unpack_from("<HH", body)
            for k in range((size - 6) // 6):
                found[sheet, row, column + k] = _short(struct.unpack_from("<I", body, 6 + 6 * k)[0])
    return found


def _workbook(data):
    """The stream of the workbook."""
    sector = 1 << struct.unpack_from("<H", data, 30)[0]
    tables = struct.unpack_from("<109I", data, 76)[: struct.unpack_from("<I", data, 44)[0]]
    after = [k for table in tables for k in struct.unpack_from(f"<{sector // 4}I", data, 512 + table * sector)]

    def chain(first):
        parts = []
        while first < END:
            parts.append(data[512 + first * sector :][:sector])
            first = after[first]
        return b"".join(parts)

    entries = chain(struct.unpack_from("<I", data, 48)[0])
    for k in range(0, len(entries), 128):
        name = entries[k : k + max(struct.unpack_from("<H", entries, k + 64)[0] - 2, 0)].decode("utf-16le")
        if name == "Workbook":
            first, size = struct.unpack_from("<II", entries, k + 116)
            return chain(first)[:size]
    raise ValueError("there is no workbook")


def _short(value):
    """A number of 30 bits: a whole one, or the upper half of a double; maybe hundredths."""
    if value & 2:
        whole = struct.unpack("<i", struct.pack("<I", value))[0] >> 2
        return whole / 100 if value & 1 else float(whole)
    double = struct.unpack("<d", struct.pack("<Q", (value & 0xFFFFFFFC) << 32))[0]
    return double / 100 if value & 1 else double
