"""Packets of pcap and pcapng files, of either byte order."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from backend.files.report import Findings

# First four octets -> byte order and units of time in a second.
_PCAP = {
    b"\xd4\xc3\xb2\xa1": ("<", 1e6),
    b"\xa1\xb2\xc3\xd4": (">", 1e6),
    b"\x4d\x3c\xb2\xa1": ("<", 1e9),
    b"\xa1\xb2\x3c\x4d": (">", 1e9),
}
_PCAPNG = b"\x0a\x0d\x0d\x0a"
_ORDERS = {b"\x4d\x3c\x2b\x1a": "<", b"\x1a\x2b\x3c\x4d": ">"}
_LARGEST_PACKET = 1 << 18
_SECTION, _INTERFACE, _OLD_PACKET, _SIMPLE, _ENHANCED = 0x0A0D0D0A, 1, 2, 3, 6


@dataclass(frozen=True)
class Packet:
    """One packet: its octets in the file, its length on the wire, when it was captured, its kind of link."""

    start: int
    end: int
    length: int
    time_s: float
    link: int


def is_capture(head: bytes) -> bool:
    """Whether a file is a capture."""
    return head[:4] in _PCAP or (head[:4] == _PCAPNG and head[8:12] in _ORDERS)


def packets_of(data: bytes, findings: Findings) -> Iterator[Packet]:
    """Yield the packets; warns where the file ends within one or goes on with something else."""
    return _pcapng(data, findings) if data[:4] == _PCAPNG else _pcap(data, findings)


def _cut(position: int, data: bytes, findings: Findings) -> None:
    findings.warn(
        "capture_cut",
        f"From byte {position} on the capture is no longer in order; its last {len(data) - position} bytes were left "
        "out.",
    )


def _pcap(data: bytes, findings: Findings) -> Iterator[Packet]:
    order, units = _PCAP[data[:4]]
    if len(data) < 24:
        _cut(0, data, findings)
        return
    link = struct.unpack_from(order + "I", data, 20)[0] & 0xFFFF
    record = struct.Struct(order + "IIII")
    position = 24
    while position < len(data):
        if position + 16 > len(data):
            _cut(position, data, findings)
            return
        seconds, fraction, captured, length = record.unpack_from(data, position)
        start = position + 16
        if captured > _LARGEST_PACKET or start + captured > len(data):
            _cut(position, data, findings)
            return
        position = start + captured
        yield Packet(start, position, length, seconds + fraction / units, link)


def _pcapng(data: bytes, findings: Findings) -> Iterator[Packet]:
    order = "<"
    links: list[tuple[int, float]] = []
    position = 0
    while position < len(data):
        if data[position : position + 4] == _PCAPNG:
            order = _ORDERS.get(data[position + 8 : position + 12], order)
            links = []
        if position + 12 > len(data):
            _cut(position, data, findings)
            return
        kind, size = struct.unpack_from(order + "II", data, position)
        end = position + size
        if size < 12 or size % 4 or end > len(data):
            _cut(position, data, findings)
            return
        body = position + 8
        try:
            if kind == _INTERFACE:
                links.append((struct.unpack_from(order + "H", data, body)[0], _units(data, body + 8, end - 4, order)))
            elif kind in (_ENHANCED, _OLD_PACKET):
                which = struct.unpack_from(order + ("I" if kind == _ENHANCED else "H"), data, body)[0]
                high, low, captured, length = struct.unpack_from(order + "IIII", data, body + 4)
                link, units = links[which]
                if body + 20 + captured > end:
                    _cut(position, data, findings)
                    return
                time_s = (high << 32 | low) / units
                yield Packet(body + 20, body + 20 + captured, length, time_s, link)
            elif kind == _SIMPLE:
                length = struct.unpack_from(order + "I", data, body)[0]
                start = body + 4
                yield Packet(start, min(start + length, end - 4), length, float("nan"), links[0][0])
        except (struct.error, IndexError):
            _cut(position, data, findings)
            return
        position = end


def _units(data: bytes, position: int, end: int, order: str) -> float:
    """Units of time in a second, told by an interface's option if_tsresol; microseconds without it."""
    while position + 4 <= end:
        code, size = struct.unpack_from(order + "HH", data, position)
        if code == 0:
            break
        if code == 9 and size:
            power = data[position + 4]
            return float(2 ** (power & 0x7F)) if power & 0x80 else float(10**power)
        position += 4 + (size + 3) // 4 * 4
    return 1e6
