"""Checksums of FFV1, which FFmpeg compares but only logs, painting over what is damaged.

A packet of FFV1 version 3 is a row of slices (RFC 9043, section 4.8). A slice with a checksum ends in 3 bytes of size
(without these 8), one of status and 4 of parity, chosen so that the CRC of the whole slice is zero. That CRC shifts
bits out at the top, zlib's at the bottom; on bytes with their bits reversed they agree.
"""

from __future__ import annotations

import zlib

REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
FOOTER, ZERO = 8, 0xFFFFFFFF
"""Size of a slice's footer, and what zlib calls a remainder of zero after starting from zero; of the format."""


def intact(packet: bytes) -> bool:
    """Whether every slice of an FFV1 packet has a checksum that is right."""
    end = len(packet)
    while end >= FOOTER:
        first = end - FOOTER - int.from_bytes(packet[end - 8 : end - 5], "big")
        if first < 0 or zlib.crc32(packet[first:end].translate(REVERSED), ZERO) != ZERO:
            return False
        end = first
    return end == 0 and len(packet) > 0
