"""Network captures, pcap and pcapng: the datagrams and connections that carried ASTERIX.

Ethernet (with VLAN tags, or LLC), Linux cooked, loopback and raw IP; IPv4 and IPv6 with fragments; UDP, and TCP put
in order. What a port carried counts as ASTERIX where most of its datagrams are whole data blocks.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from backend.files.asterix.blocks import Carried, Gap, Moved, Payload, is_chain, next_block
from backend.files.asterix.packets import Packet, packets_of
from backend.files.report import Findings, some

_VLAN = {0x8100, 0x88A8, 0x9100, 0x9200}
_IPV4, _IPV6 = 0x0800, 0x86DD
_UDP, _TCP, _FRAGMENT = 17, 6, 44
_EXTENSIONS = {0, 43, 60, 135, 139, 140}
_ETHERNET, _NULL, _LOOP, _SLL, _SLL2 = 1, 0, 108, 113, 276
_RAW = {12, 14, 101, 228, 229}

_Flow = tuple[bytes, bytes, int, int]


@dataclass
class _Fragments:
    """Pieces of one IP datagram: offset -> its octets; `length` once the last one is there."""

    pieces: dict[int, tuple[int, int]] = field(default_factory=dict)
    length: int = -1

    def whole(self, data: bytes) -> bytes | None:
        """The datagram's payload, None while a piece is missing."""
        out = bytearray()
        for offset in sorted(self.pieces):
            if offset > len(out):
                return None
            start, end = self.pieces[offset]
            out += data[start + len(out) - offset : end]
        return bytes(out[: self.length]) if 0 <= self.length <= len(out) else None


@dataclass
class _Unpacker:
    """Goes through the packets and keeps what they carried."""

    data: bytes
    together: bytearray = field(default_factory=bytearray)
    moved: Moved = field(default_factory=Moved)
    datagrams: dict[int, list[Payload]] = field(default_factory=lambda: defaultdict(list))
    segments: dict[_Flow, list[tuple[int, int, int, float]]] = field(default_factory=lambda: defaultdict(list))
    fragments: dict[tuple[bytes, bytes, int, int], _Fragments] = field(default_factory=dict)
    cut: list[Gap] = field(default_factory=list)
    others: int = 0

    def add(self, packet: Packet) -> None:
        """Take one packet apart."""
        start = self._network(packet)
        if start is None:
            self.others += 1
            return
        protocol, position = start
        try:
            if protocol == _IPV4:
                self._ipv4(packet, position)
            elif protocol == _IPV6:
                self._ipv6(packet, position)
            elif protocol <= 1500:
                # IEEE 802.3: a length, and behind three octets of LLC the data.
                behind = min(position + protocol, packet.end)
                self.datagrams[-1].append(Payload(position + 3, behind, packet.time_s))
            else:
                self.others += 1
        except IndexError:
            self._lost(packet)

    def _network(self, packet: Packet) -> tuple[int, int] | None:
        """Protocol and position of the layer above the link; None for links that carry none."""
        data, position, link = self.data, packet.start, packet.link
        if packet.end - position < 20:
            return None
        if link == _ETHERNET:
            position += 12
        elif link == _SLL:
            position += 14
        elif link == _SLL2:
            return data[position] << 8 | data[position + 1], position + 20
        elif link in (_NULL, _LOOP):
            return (_IPV4 if data[position + 4] >> 4 == 4 else _IPV6), position + 4
        elif link in _RAW:
            return (_IPV4 if data[position] >> 4 == 4 else _IPV6), position
        else:
            return None
        protocol = data[position] << 8 | data[position + 1]
        while protocol in _VLAN and position + 6 <= packet.end:
            position += 4
            protocol = data[position] << 8 | data[position + 1]
        return protocol, position + 2

    def _ipv4(self, packet: Packet, position: int) -> None:
        data = self.data
        header = (data[position] & 15) * 4
        end = position + (data[position + 2] << 8 | data[position + 3])
        if end > packet.end:
            self._lost(packet)
            return
        source, target = data[position + 12 : position + 16], data[position + 16 : position + 20]
        flags = data[position + 6] << 8 | data[position + 7]
        protocol = data[position + 9]
        if flags & 0x3FFF:
            key = (source, target, data[position + 4] << 8 | data[position + 5], protocol)
            self._fragment(key, (flags & 0x1FFF) * 8, bool(flags & 0x2000), position + header, end, packet)
            return
        self._transport(protocol, data, position + header, end, 0, (source, target), packet)

    def _ipv6(self, packet: Packet, position: int) -> None:
        data = self.data
        end = position + 40 + (data[position + 4] << 8 | data[position + 5])
        if end > packet.end:
            self._lost(packet)
            return
        source, target = data[position + 8 : position + 24], data[position + 24 : position + 40]
        protocol = data[position + 6]
        position += 40
        while protocol in _EXTENSIONS and position < end:
            protocol, position = data[position], position + 8 * (data[position + 1] + 1)
        if protocol == _FRAGMENT:
            offset = data[position + 2] << 8 | data[position + 3]
            key = (source, target, int.from_bytes(data[position + 4 : position + 8], "big"), data[position])
            self._fragment(key, offset & 0xFFF8, bool(offset & 1), position + 8, end, packet)
            return
        self._transport(protocol, data, position, end, 0, (source, target), packet)

    def _fragment(
        self, key: tuple[bytes, bytes, int, int], offset: int, more: bool, start: int, end: int, packet: Packet
    ) -> None:
        found = self.fragments.setdefault(key, _Fragments())
        found.pieces[offset] = (start, end)
        if not more:
            found.length = offset + end - start
        whole = found.whole(self.data)
        if whole is None:
            return
        del self.fragments[key]
        place = self._put_together(whole, found.pieces[0][0], packet.time_s)
        self._transport(key[3], whole, 0, len(whole), place, key[:2], packet)

    def _put_together(self, octets: bytes, in_file: int, time_s: float) -> int:
        """Add octets behind the file; returns their place."""
        place = len(self.data) + len(self.together)
        self.moved.note(place, in_file, time_s)
        self.together += octets
        return place

    def _transport(
        self, protocol: int, data: bytes, start: int, end: int, place: int, ends: tuple[bytes, bytes], packet: Packet
    ) -> None:
        """Keep the payload of a UDP datagram or a TCP segment; `place` is that of `data` behind the file."""
        if protocol == _UDP:
            length = data[start + 4] << 8 | data[start + 5]
            behind = start + length if length >= 8 else end
            if behind > end:
                self._lost(packet)
                return
            if behind > start + 8:
                port = data[start + 2] << 8 | data[start + 3]
                self.datagrams[port].append(Payload(place + start + 8, place + behind, packet.time_s))
        elif protocol == _TCP:
            body = start + (data[start + 12] >> 4) * 4
            if body < end:
                ports = (
                    int.from_bytes(data[start : start + 2], "big"),
                    int.from_bytes(data[start + 2 : start + 4], "big"),
                )
                number = int.from_bytes(data[start + 4 : start + 8], "big")
                self.segments[(*ends, *ports)].append((number, place + body, place + end, packet.time_s))
        else:
            self.others += 1

    def _lost(self, packet: Packet) -> None:
        self.cut.append(Gap(packet.start, packet.end, "the packet was cut off when it was captured"))

    def streams(self) -> Iterator[tuple[int, Payload]]:
        """Port and payload of what each side of a connection sent, in order, without repeats; a loss parts it."""
        for (_, _, source, target), segments in self.segments.items():
            base = segments[0][0]
            # Sequence numbers wrap; seen from the first, they lie within half the circle.
            placed = sorted(
                ((number - base + 2**31) % 2**32 - 2**31, start, end, t) for number, start, end, t in segments
            )
            first = len(self.data) + len(self.together)
            expected = placed[0][0]
            time_s = placed[0][3]
            for number, start, end, t in placed:
                if number > expected:
                    behind = len(self.data) + len(self.together)
                    yield min(source, target), Payload(first, behind, time_s)
                    first, expected, time_s = behind, number, t
                skipped = expected - number
                if skipped < end - start:
                    octets = self._octets(start + skipped, end)
                    self._put_together(octets, start + skipped, t)
                    expected += len(octets)
            yield min(source, target), Payload(first, len(self.data) + len(self.together), time_s)

    def _octets(self, start: int, end: int) -> bytes:
        size = len(self.data)
        return self.data[start:end] if start < size else bytes(self.together[start - size : end - size])


def open_capture(data: bytes, findings: Findings) -> Carried:
    """Find what carried ASTERIX in a capture."""
    unpacker = _Unpacker(data)
    for packet in packets_of(data, findings):
        if packet.end - packet.start < packet.length:
            unpacker.cut.append(Gap(packet.start, packet.end, "the packet was cut off when it was captured"))
        else:
            unpacker.add(packet)
    by_port = {f"UDP {number}" if number >= 0 else "LLC": found for number, found in unpacker.datagrams.items()}
    for number, payload in unpacker.streams():
        by_port.setdefault(f"TCP {number}", []).append(payload)
    whole = data + unpacker.together if unpacker.together else data
    octets = np.frombuffer(whole, np.uint8)
    payloads: list[Payload] = []
    foreign: dict[str, int] = {}
    for port, found in by_port.items():
        # A connection may have been under way when the capture began.
        starts = [next_block(octets, p.start, min(p.end, p.start + 2**17)) if "TCP" in port else p.start for p in found]
        good = sum(p.start < p.end and is_chain(whole, s, p.end, 8) for s, p in zip(starts, found, strict=True))
        if good and 2 * good >= len(found):
            payloads += found
        else:
            foreign[port] = len(found)
    others = unpacker.others + sum(foreign.values())
    if others:
        ports = some(sorted(foreign)) if foreign else "–"
        findings.warn("other_traffic", f"Packets that carry no ASTERIX were left out; ports: {ports}.", others)
    if unpacker.fragments:
        findings.warn(
            "fragments_missing",
            "Datagrams were sent in fragments of which the capture lacks some; they were left out.",
            len(unpacker.fragments),
        )
    payloads.sort(key=lambda p: unpacker.moved.file_position(p.start))
    return Carried("capture", whole, payloads, "utc", unpacker.moved, unpacker.cut if payloads else [])
