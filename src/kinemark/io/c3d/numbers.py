"""Numbers as the three families of processors stored them.

Intel and SGI/MIPS files hold IEEE 754 floats, little and big end first. A DEC file holds VAX F floats: two
little-endian 16-bit words, the *high* word first. With s sign, e exponent (8 bits), m mantissa (23 bits),

    IEEE   (-1)^s (2^23 + m) 2^(e - 150)      for 1 <= e <= 254                       (1)
    VAX    (-1)^s (2^23 + m) 2^(e - 152)      for e >= 1                              (2)

so the same bits with e less by 2 are the same number (3). Two VAX exponents, 1 and 2, fall into IEEE's
denormal range, where (2) is computed and rounded (4). VAX e = 0 is zero, or with s = 1 the "reserved operand",
which stands for NaN here (5). VAX ends at 1.7e38; larger numbers cannot be written.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

_EXPONENT, _MANTISSA, _SIGN = np.uint32(0xFF), np.uint32(0x7FFFFF), np.uint32(1 << 31)
"""Bits of a float; of the formats of IEEE and DEC."""
_TWO = np.uint32(2 << 23)  # two in the exponent; of the formats of IEEE and DEC


class ByteOrder(IntEnum):
    """The processor byte of a C3D file."""

    INTEL = 84
    DEC = 85
    SGI = 86

    @property
    def char(self) -> str:
        """NumPy's sign for the order of the bytes in an integer."""
        return ">" if self is ByteOrder.SGI else "<"


def float_of_vax(bits: NDArray[np.uint32]) -> NDArray[np.float32]:
    """IEEE numbers of VAX F bit patterns (high word in the high half); any shape."""
    e = (bits >> np.uint32(23)) & _EXPONENT
    out = (bits - _TWO).view(np.float32).copy()  # (3)
    if (few := e < 3).any():
        b = bits[few]
        sign = np.where(b & _SIGN, -1.0, 1.0)
        small = sign * np.ldexp((b & _MANTISSA) + 2.0**23, e[few].astype(np.int64) - 152)  # (2)
        small = np.where(e[few] == 0, np.where(b & _SIGN, np.nan, 0.0), small)  # (5)
        out[few] = small.astype(np.float32)  # (4)
    return out


def vax_of_float(values: NDArray[np.float32]) -> NDArray[np.uint32]:
    """VAX F bit patterns of IEEE numbers; NaN becomes the reserved operand, what is below 2^-128 zero.

    Raises:
        ValueError: a number is infinite or beyond 1.7e38.
    """
    bits = np.ascontiguousarray(values, np.float32).view(np.uint32)
    e = (bits >> np.uint32(23)) & _EXPONENT
    nan = (e == 255) & ((bits & _MANTISSA) != 0)
    if ((e >= 254) & ~nan).any():
        raise ValueError("a number beyond 1.7e38 has no DEC float; write the file in Intel order")
    out = np.asarray(bits + _TWO, np.uint32)  # (3)
    if (few := (e == 0) | nan).any():
        b = bits[few]
        m, sign = b & _MANTISSA, b & _SIGN
        upper = sign | np.uint32(2 << 23) | ((m << np.uint32(1)) & _MANTISSA)  # e = 2 in (2)
        lower = sign | np.uint32(1 << 23) | ((m << np.uint32(2)) & _MANTISSA)  # e = 1 in (2)
        small = np.where(m >= 1 << 22, upper, np.where(m >= 1 << 21, lower, np.uint32(0)))
        out[few] = np.where(nan[few], _SIGN, small)  # (5)
    return out


def decode_floats(raw: NDArray[np.uint8], order: ByteOrder) -> NDArray[np.float32]:
    """Floats (…, n) of contiguous bytes (…, 4 n)."""
    if order is not ByteOrder.DEC:
        values = raw.view(f"{order.char}f4").astype(np.float32)
        values.view(np.uint32)[np.isnan(values)] |= np.uint32(1 << 22)  # a signalling NaN would warn at every turn
        return values
    words = raw.view("<u2").astype(np.uint32)
    return float_of_vax((words[..., ::2] << np.uint32(16)) | words[..., 1::2])


def encode_floats(values: NDArray[Any], order: ByteOrder) -> NDArray[np.uint8]:
    """Bytes (…, 4 n) of floats (…, n); the inverse of `decode_floats`.

    Raises:
        ValueError: DEC order and a number beyond its range.
    """
    single = np.ascontiguousarray(values, np.float32)
    if order is not ByteOrder.DEC:
        return single.astype(f"{order.char}f4").view(np.uint8)
    bits = vax_of_float(single)
    words = np.empty((*bits.shape[:-1], 2 * bits.shape[-1]), "<u2")
    words[..., ::2], words[..., 1::2] = bits >> np.uint32(16), bits & np.uint32(0xFFFF)
    return words.view(np.uint8)


def decode_words(raw: NDArray[np.uint8], order: ByteOrder, *, signed: bool = True) -> NDArray[Any]:
    """16-bit integers (…, n) of contiguous bytes (…, 2 n), in the machine's own order."""
    kind = "i2" if signed else "u2"
    return raw.view(f"{order.char}{kind}").astype(kind)


def encode_words(values: NDArray[Any], order: ByteOrder) -> NDArray[np.uint8]:
    """Bytes (…, 2 n) of integers (…, n) from −32 768 to 65 535."""
    return (np.ascontiguousarray(values).astype(np.int64) & 0xFFFF).astype(f"{order.char}u2").view(np.uint8)
