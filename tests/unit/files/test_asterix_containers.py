"""Captures, the FINAL format, and files that are broken in every way that was met."""

import gzip
import struct

import numpy as np
import pytest

from algorithms.errors import InputError, UnsupportedFormatError
from tests.asterix_files import (
    block,
    cat048,
    ethernet,
    final,
    ipv4,
    north,
    pcap,
    pcapng,
    plot,
    source,
    tcp,
    turning_radar,
    udp,
)

T = 36_000.0
DAY = 1_772_323_200  # 2026-03-01, midnight
BLOCKS = [cat048(plot(T + k, 30 + k, 10 * k)) for k in range(20)]


def datagrams(blocks=BLOCKS, *, start=DAY + T, vlan=0, wrap=lambda data: data):
    return [(start + k + 0.25, ethernet(ipv4(udp(wrap(b))), vlan=vlan)) for k, b in enumerate(blocks)]


def told(report, code):
    return [(r.row, r.detail) for r in report.rejections if r.code == code]


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("nanoseconds", [True, False])
@pytest.mark.parametrize("vlan", [0, 1, 2])
def test_pcap_of_either_byte_order_with_and_without_vlan(read, order, nanoseconds, vlan):
    plots, report = read(pcap(datagrams(vlan=vlan), order=order, nanoseconds=nanoseconds))
    assert (len(plots), report.rows_read) == (20, 20)
    assert plots.start_utc == "2026-03-01T10:00:00Z"
    assert plots.time_s.tolist() == list(range(20))


@pytest.mark.parametrize("order", ["<", ">"])
def test_pcapng(read, order):
    plots, _ = read(pcapng(datagrams(), order=order))
    assert (len(plots), plots.start_utc) == (20, "2026-03-01T10:00:00Z")


def test_links_other_than_ethernet_and_ip_version_6(read):
    data = udp(BLOCKS[0])
    ipv6 = struct.pack(">IHBB", 6 << 28, len(data) + 8, 0, 64) + bytes(32) + struct.pack(">BBHI", 17, 0, 0, 0) + data
    cooked = struct.pack(">HHHQH", 0, 1, 6, 0, 0x0800) + ipv4(data)
    cooked2 = struct.pack(">HHIHBBQ", 0x86DD, 0, 1, 1, 0, 6, 0) + ipv6
    bare = BLOCKS[0]
    llc = b"\1\2\3\4\5\6" * 2 + struct.pack(">H", len(bare) + 3) + b"\x42\x42\x03" + bare + bytes(8)
    packets = {101: ipv6, 113: cooked, 276: cooked2, 0: struct.pack("<I", 2) + ipv4(data), 1: llc}
    for link, packet in packets.items():
        plots, _ = read(pcap([(DAY + T, packet)], link=link))
        assert len(plots) == 1, link


def test_a_capture_over_midnight_has_the_date_of_each_record(read):
    blocks = [cat048(plot((86_390 + 2 * k) % 86_400, 30, 36 * k)) for k in range(10)]
    packets = [(DAY + 86_390 + 2 * k + 1.5, ethernet(ipv4(udp(b)))) for k, b in enumerate(blocks)]
    plots, report = read(pcap(packets))
    assert plots.time_s.tolist() == list(range(0, 20, 2))
    assert plots.start_utc == "2026-03-01T23:59:50Z"
    assert "midnight_crossed" in [w.code for w in report.warnings]


def test_fragments_are_put_together_and_missing_ones_counted(read, warning):
    whole = udp(b"".join(BLOCKS))
    parts = [ipv4(whole[i : i + 80], identity=5, offset=i, more=i + 80 < len(whole)) for i in range(0, len(whole), 80)]
    lost = ipv4(whole[:80], identity=6, more=True)
    packets = [(DAY + T, ethernet(p)) for p in (parts[1], parts[0], lost, *parts[2:])]
    plots, report = read(pcap(packets))
    assert len(plots) == 20
    assert warning(report, "fragments_missing").count == 1


def test_a_connection_out_of_order_with_repeats_and_a_loss(read):
    stream = b"".join(BLOCKS)
    cuts = [stream[i : i + 30] for i in range(0, len(stream), 30)]
    base = 2**32 - 120
    packets = [(DAY + T, ethernet(ipv4(tcp(c, base + 30 * k), protocol=6))) for k, c in enumerate(cuts)]
    packets[2], packets[3] = packets[3], packets[2]
    plots, report = read(pcap([*packets[:5], packets[4], *packets[5:]]))
    assert (len(plots), report.rejections) == (20, ())
    plots, report = read(pcap([*packets[:6], *packets[7:]]))
    assert 15 < len(plots) < 20
    assert report.rejections
    assert report.rows_read == len(plots) + len(report.rejections)


def test_other_traffic_is_counted_and_a_capture_of_something_else_says_so(read, warning):
    foreign = [
        (DAY + T, ethernet(ipv4(udp(b"GET / HTTP/1.1", port=80)))),
        (DAY + T, ethernet(b"arp" * 20, protocol=0x0806)),
    ]
    plots, report = read(pcap(datagrams() + foreign))
    assert len(plots) == 20
    assert warning(report, "other_traffic").count == 2
    assert "UDP 80" in warning(report, "other_traffic").detail
    with pytest.raises(InputError) as e:
        read(pcap(foreign))
    assert e.value.code == "no_asterix"


def test_packets_that_were_cut_and_captures_that_end_within_one(read, warning):
    plots, report = read(pcap(datagrams(), snap=50) + pcap(datagrams(start=DAY + T + 100))[24:])
    assert len(plots) == 20
    assert len(told(report, "no_data_block")) == 20
    whole = pcap(datagrams())
    plots, report = read(whole[:-5])
    assert (len(plots), warning(report, "capture_cut").count) == (19, 1)
    claims = whole[:24] + whole[24:32] + struct.pack("<II", 1 << 30, 1 << 30) + whole[40:]
    with pytest.raises(InputError):
        read(claims)


def test_a_capture_whose_clock_is_elsewhere(read, warning):
    _, report = read(pcap(datagrams(start=DAY + T + 7200)))
    assert "7200" in warning(report, "capture_clock_differs").detail


def test_final_format_with_a_damaged_frame(read):
    data = final(BLOCKS)
    plots, report = read(data)
    assert (len(plots), report.rejections) == (20, ())
    frame = len(final(BLOCKS[:1]))
    broken = data[: 3 * frame] + b"\xff\xff" + data[3 * frame + 2 :]
    plots, report = read(broken)
    assert len(plots) == 19
    assert told(report, "no_data_block") == [(4, f"bytes {3 * frame} to {4 * frame - 1}: no frame of the FINAL format")]


def test_a_record_without_a_time_takes_that_of_the_recorder(read, warning):
    timeless = cat048({n: v for n, v in plot(0).items() if n != "140"})
    plots, report = read(final([timeless], 40_000.25))
    assert plots.time_s.tolist() == [40_000.25]
    assert warning(report, "time_of_receipt").count == 1


def test_packed_files(read):
    assert len(read(gzip.compress(b"".join(BLOCKS)))[0]) == 20


def test_a_file_cut_in_the_middle_of_a_record(read):
    data = b"".join(BLOCKS)
    plots, report = read(data[:-5])
    last = len(data) - len(BLOCKS[-1])
    assert len(plots) == 19
    ((row, detail),) = told(report, "no_data_block")
    assert row == 20
    assert detail.startswith(
        f"bytes {last} to {len(data) - 6}: a data block of category 48 claims {len(BLOCKS[-1])} bytes"
    )


def test_a_file_that_begins_in_the_middle_of_a_record(read):
    plots, report = read(b"".join(BLOCKS)[7:])
    assert len(plots) == 19
    assert report.rejections[0].detail.startswith(f"bytes 0 to {len(BLOCKS[0]) - 8}: ")


def test_a_wrong_length_costs_one_block(read):
    for length in (0, 2, 5, 65_535):
        broken = BLOCKS[4][:1] + length.to_bytes(2, "big") + BLOCKS[4][3:]
        plots, report = read(b"".join([*BLOCKS[:4], broken, *BLOCKS[5:]]))
        assert len(plots) == 19, length
        assert 1 <= len(report.rejections) <= 2
        assert report.rows_read == report.rows_accepted + len(report.rejections)


def test_a_record_that_does_not_decode_is_told_with_item_and_byte(read):
    records = cat048(plot(T), plot(T + 1) | {"130": {"SRL": (1.0, "°")}})
    # The compound item claims all its subitems, which are not there.
    broken = records[:-2] + b"\xfe" + records[-1:]
    plots, report = read(b"".join([BLOCKS[3], broken, *BLOCKS[:3]]))
    assert len(plots) == 5
    ((row, detail),) = told(report, "undecodable_record")
    assert row == 3
    at = len(BLOCKS[3]) + len(cat048(plot(T)))
    assert detail.startswith(
        f"byte {at}: a record of CAT 048 does not decode by edition 1.32: item 130 runs 6 bytes past"
    )


def test_unknown_categories_among_known_ones_are_counted(read, warning):
    data = bytes([205, 0, 5, 1, 2]) + BLOCKS[0] + bytes([99, 0, 6, 1, 2, 3]) + BLOCKS[1] + block(8, {"010": source()})
    plots, report = read(data)
    assert (len(plots), report.rows_read) == (2, 2)
    assert "CAT 008 (1), CAT 099 (1), CAT 205 (1)" in warning(report, "categories_unread").detail


def test_random_octets_between_blocks(read):
    chance = np.random.default_rng(3)
    data = b"".join(b + chance.integers(0, 256, 300, dtype=np.uint8).tobytes() * (k == 7) for k, b in enumerate(BLOCKS))
    plots, report = read(data)
    assert len(plots) >= 19
    assert report.rejections
    assert report.rows_read == report.rows_accepted + len(report.rejections)


@pytest.mark.parametrize("seed", range(30))
def test_flipped_octets_never_stop_the_reading(read, seed):
    chance = np.random.default_rng(seed)
    data, _ = turning_radar(6)
    raw = (b"".join(data), pcap(datagrams(data)), final(data), pcapng(datagrams(data)))[seed % 4]
    octets = np.frombuffer(raw, np.uint8).copy()
    octets[chance.integers(40, len(octets), 25)] = chance.integers(0, 256, 25)
    try:
        plots, report = read(octets.tobytes())
    except (InputError, UnsupportedFormatError):
        return
    assert report.rows_read == report.rows_accepted + len(report.rejections) == len(plots) + len(report.rejections)


def test_octets_in_the_wrong_order_are_no_asterix(read):
    data = b"".join([*BLOCKS, north(T)])
    swapped = np.frombuffer(data[: len(data) // 2 * 2], np.uint8).reshape(-1, 2)[:, ::-1].tobytes()
    with pytest.raises((InputError, UnsupportedFormatError)):
        read(swapped)
