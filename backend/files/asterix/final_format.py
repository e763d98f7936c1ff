"""The FINAL format of ASTERIX recorders.

Each frame: two octets length of the whole frame, board, line, day of the recording, three octets time of day in steps
of 10 ms, data blocks, four octets A5.
"""

from __future__ import annotations

from backend.files.asterix.blocks import Carried, Gap, Payload, is_chain

_HEADER = 8
_PAD = b"\xa5\xa5\xa5\xa5"


def _frame_end(data: bytes, position: int) -> int:
    """Position behind the frame at `position`, 0 where there is none."""
    end = position + int.from_bytes(data[position : position + 2], "big")
    if end < position + _HEADER + len(_PAD) or data[end - len(_PAD) : end] != _PAD:
        return 0
    return end


def is_final(head: bytes) -> bool:
    """Whether the octets begin with a frame that holds data blocks."""
    end = _frame_end(head, 0)
    return bool(end) and is_chain(head, _HEADER, end - len(_PAD))


def open_final(data: bytes) -> Carried:
    """Take the frames apart; octets between two of them are a gap."""
    payloads: list[Payload] = []
    gaps: list[Gap] = []
    position = 0
    while position < len(data):
        end = _frame_end(data, position)
        if end:
            time_s = int.from_bytes(data[position + 5 : position + 8], "big") / 100
            payloads.append(Payload(position + _HEADER, end - len(_PAD), time_s))
            position = end
            continue
        pad = data.find(_PAD, position + 1)
        behind = len(data) if pad < 0 else pad + len(_PAD)
        gaps.append(Gap(position, behind, "no frame of the FINAL format"))
        position = behind
    return Carried("FINAL", data, payloads, "day", gaps=gaps)
