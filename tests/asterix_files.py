"""Real ASTERIX bytes, written with libasterix, and the containers in which they are recorded."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import Any

import asterix.generated as gen

NM = 1852.0
CAT = {
    number: {f"{s.cv_edition[0]}.{s.cv_edition[1]}": s for s in specifications}
    for number, specifications in gen.manifest["CATS"].items()
}


def block(category: int, *records: dict[str, Any], edition: str | None = None, uap: str | None = None) -> bytes:
    """One data block."""
    editions = CAT[category]
    specification = editions[edition] if edition else list(editions.values())[-1]
    kind = specification.cv_uap.spec(uap) if uap else specification.cv_uap.cv_record
    data: bytes = specification.create([kind.create(dict(r)) for r in records]).unparse().to_bytes()
    return data


def source(sac: int = 1, sic: int = 2) -> tuple[tuple[str, int], ...]:
    return (("SAC", sac), ("SIC", sic))


def plot(time_s: float, range_nm: float = 50.0, azimuth_deg: float = 90.0, **more: Any) -> dict[str, Any]:
    """A record of CAT 048; `radar` is (SAC, SIC), the rest are items or known words."""
    record: dict[str, Any] = {
        "010": source(*more.pop("radar", (1, 2))),
        "140": (time_s, "s"),
        "020": ((more.pop("type", 5), more.pop("simulated", 0), 0, 0, 0, None),),
        "040": (("RHO", (range_nm, "NM")), ("THETA", (azimuth_deg, "°"))),
    }
    if "address" in more:
        record["220"] = more.pop("address")
    if "callsign" in more:
        record["240"] = more.pop("callsign")
    if "level" in more:
        record["090"] = (more.pop("unsure", 0), 0, ("FL", (more.pop("level"), "FL")))
    if "squawk" in more:
        record["070"] = (0, more.pop("garbled", 0), 0, 0, ("MODE3A", more.pop("squawk")))
    return record | {name.removeprefix("i"): value for name, value in more.items()}


def cat048(*records: dict[str, Any], edition: str | None = None) -> bytes:
    return block(48, *records, edition=edition)


def north(time_s: float, radar: tuple[int, int] = (1, 2), **items: Any) -> bytes:
    """A north mark of CAT 034."""
    return block(34, {"010": source(*radar), "000": 1, "030": (time_s, "s")} | {n[1:]: v for n, v in items.items()})


def sector(time_s: float, azimuth_deg: float, radar: tuple[int, int] = (1, 2)) -> bytes:
    """A sector crossing of CAT 034."""
    return block(34, {"010": source(*radar), "000": 2, "030": (time_s, "s"), "020": (azimuth_deg, "°")})


def adsb(time_s: float, latitude_deg: float, longitude_deg: float, address: int, **items: Any) -> bytes:
    """A position of CAT 021."""
    record = {
        "010": source(7, 7),
        "040": ((0, 0, 0, 0, None),),
        "073": (time_s, "s"),
        "131": (("LAT", (latitude_deg, "°")), ("LON", (longitude_deg, "°"))),
        "080": address,
        "140": (10000.0, "ft"),
    }
    return block(21, record | {n[1:]: v for n, v in items.items()})


def turning_radar(
    turns: int,
    plots: int = 8,
    *,
    period_s: float = 5.0,
    start_s: float = 36_000.0,
    marks: bool = True,
    radar: tuple[int, int] = (1, 2),
) -> tuple[list[bytes], list[int]]:
    """Data blocks of a radar that turns evenly, and the turn of each plot; azimuths also just beside north."""
    out, of = [], []
    for turn in range(turns):
        if marks:
            out.append(north(start_s + turn * period_s, radar))
        for k in range(plots):
            fraction = (k + 0.5) / plots if 0 < k < plots - 1 else (0.0005 if k == 0 else 0.9995)
            record = plot(start_s + (turn + fraction) * period_s, 20 + k, 360 * fraction, radar=radar, address=k + 1)
            out.append(cat048(record))
            of.append(turn + 1)
    return out, of


def final(blocks: Iterable[bytes], time_s: float = 36_000.0) -> bytes:
    """The FINAL format, a frame for each data block."""
    out = b""
    for data in blocks:
        out += struct.pack(">HBBB", len(data) + 12, 1, 1, 1) + int(time_s * 100).to_bytes(3, "big") + data + b"\xa5" * 4
    return out


def ipv4(data: bytes, *, protocol: int = 17, identity: int = 0, offset: int = 0, more: bool = False) -> bytes:
    flags = (0x2000 if more else 0) | offset // 8
    head = struct.pack(
        ">BBHHHBBH4s4s", 0x45, 0, 20 + len(data), identity, flags, 64, protocol, 0, b"\n\0\0\1", b"\n\0\0\2"
    )
    return head + data


def udp(data: bytes, port: int = 8600) -> bytes:
    return struct.pack(">HHHH", 4000, port, len(data) + 8, 0) + data


def tcp(data: bytes, number: int, port: int = 8600) -> bytes:
    return struct.pack(">HHIIBBHHH", port, 4000, number % 2**32, 0, 0x50, 0x18, 1000, 0, 0) + data


def ethernet(data: bytes, *, vlan: int = 0, protocol: int = 0x0800) -> bytes:
    tags = b"".join(struct.pack(">HH", 0x8100, 5) for _ in range(vlan))
    return b"\1\2\3\4\5\6" * 2 + tags + struct.pack(">H", protocol) + data


def pcap(
    packets: Sequence[tuple[float, bytes]], *, order: str = "<", nanoseconds: bool = False, link: int = 1, snap: int = 0
) -> bytes:
    """A capture; packets with their times of the epoch."""
    out = struct.pack(order + "IHHiIII", 0xA1B23C4D if nanoseconds else 0xA1B2C3D4, 2, 4, 0, 0, 65535, link)
    for time_s, data in packets:
        kept = data[:snap] if snap else data
        fraction = round((time_s % 1) * (1e9 if nanoseconds else 1e6))
        out += struct.pack(order + "IIII", int(time_s), fraction, len(kept), len(data)) + kept
    return out


def pcapng(packets: Sequence[tuple[float, bytes]], *, order: str = "<", link: int = 1) -> bytes:
    """A capture of the newer form, with times in nanoseconds."""

    def ng_block(kind: int, body: bytes) -> bytes:
        body += bytes(-len(body) % 4)
        return struct.pack(order + "II", kind, len(body) + 12) + body + struct.pack(order + "I", len(body) + 12)

    out = ng_block(0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1))
    option = struct.pack(order + "HHB3xHH", 9, 1, 9, 0, 0)
    out += ng_block(1, struct.pack(order + "HHI", link, 0, 65535) + option)
    for time_s, data in packets:
        stamp = int(time_s * 1e9)
        out += ng_block(
            6, struct.pack(order + "IIIII", 0, stamp >> 32, stamp & 0xFFFFFFFF, len(data), len(data)) + data
        )
    return out
