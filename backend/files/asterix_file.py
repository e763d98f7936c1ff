"""ASTERIX recordings: raw data blocks, network captures and the FINAL format.

libasterix takes a second and 90 MB to load, so it is loaded where such a file is read, and nowhere else.
"""

from __future__ import annotations

from backend.files.asterix.blocks import is_start_of_blocks
from backend.files.asterix.final_format import is_final
from backend.files.asterix.packets import is_capture
from backend.files.reader import Part, Reader, Source
from backend.files.truth_file import TruthPoints


def _detect(source: Source) -> bool:
    head = source.content.head
    if source.content.is_text:
        return False
    if is_capture(head) or is_final(head):
        return True
    if not is_start_of_blocks(head):
        return False
    from backend.files.asterix.reading import decodes

    return decodes(head)


def _read(source: Source) -> Part:
    from backend.files.asterix.reading import read_plots

    return read_plots(source)


def _read_truth(source: Source) -> TruthPoints:
    from backend.files.asterix.reading import read_truth

    return read_truth(source)


READER = Reader(
    name="asterix",
    title="ASTERIX (CAT 001, 002, 010, 020, 021, 034, 048, 062): raw, pcap, pcapng, FINAL",
    kinds=("polar_plots",),
    detect=_detect,
    read=_read,
    options=("edition", "scan_cut", "scan_period_s"),
    read_truth=_read_truth,
)
