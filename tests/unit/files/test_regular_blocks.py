"""Text read in blocks by Arrow gives what text read line by line gives: values, rejections, warnings."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from algorithms.errors import InputError
from backend.files import records, regular_blocks
from backend.files.content import inspect
from backend.files.options import ReadLimits
from backend.files.reading import NamedFile, read_recording
from backend.files.regular_blocks import Layout, OtherBlock, RegularBlock, read_blocks
from backend.files.report import Findings

HEADER = "time_s,target,toa_1_ns,toa_2_ns,toa_3_ns,toa_4_ns,altitude_m\n"


def rows(count: int) -> list[str]:
    return [
        f"{i * 0.1:.3f},борт {i % 3},{1000.125 + i},{2000 + i / 3},,{3e3 + i:.6e},{9000 + i % 7}\n"
        for i in range(count)
    ]


def changed(place: int, line: str) -> str:
    lines = rows(60)
    lines[place] = line
    return HEADER + "".join(lines)


CASES = {
    "regular": HEADER + "".join(rows(60)),
    "no line end at the end": (HEADER + "".join(rows(60))).rstrip("\n"),
    "two line ends of Windows": (HEADER + "".join(rows(60))).replace("\n", "\r\n"),
    "a line end of old Macs": changed(30, "3,a,1,2,3,4,5\r3.05,a,1,2,3,4,6\n"),
    "a blank line": changed(30, "\n"),
    "a line of spaces": changed(30, "   \n"),
    "too few cells": changed(30, "3,a,1,2\n"),
    "too many cells": changed(30, "3,a,1,2,3,4,5,6,7\n"),
    "more cells, all empty": changed(30, "3,a,1,2,3,4,5,,\n"),
    "a word": changed(30, "3,a,one,2,3,4,5\n"),
    "a word for nothing": changed(30, "3,a,NaN,2,null,4,5\n"),
    "not finite": changed(30, "3,a,inf,2,1e999,4,5\n"),
    "a plus and a bare point": changed(30, "3,a,+1,2.,.5,4,5\n"),
    "spaces around": changed(30, " 3 , a ,1 , 2,3,4,5\n"),
    "digits in groups": changed(30, "3,a,1_000,2,3,4,5\n"),
    "digits of another script": changed(30, "3,a,\u0661,2,3,4,5\n"),
    "hexadecimal": changed(30, "3,a,0x10,2,3,4,5\n"),
    "no time": changed(30, ",a,1,2,3,4,5\n"),
    "out of range": changed(30, "3,a,1,2,3,4,99999999999\n"),
    "nothing measured": changed(30, "3,a,,,,,\n"),
    "the same row twice": changed(30, rows(30)[29]),
    "decimal commas": (HEADER + "".join(rows(60))).replace(",", ";").replace(".", ","),
    "semicolons": (HEADER + "".join(rows(60))).replace(",", ";"),
    "decimal commas among points": changed(30, "3,a,1§5,2.5,3,4,5\n").replace(",", ";").replace("§", ","),
    "whole numbers, one with a point": HEADER + "".join(f"{i},a,1,2,3,4,{i}{'.0' * (i == 30)}\n" for i in range(60)),
    "points in the names alone": HEADER + "".join(f"{i},a.b,1,2,3,4,5\n" for i in range(60)),
    "parts of whole numbers without a point": HEADER + "".join(f"{i},a,1,2,3,4,25e-1\n" for i in range(60)),
    "every row four times": HEADER + "".join(row for row in rows(15) for _ in range(4)),
    "minus zero": HEADER + "".join(f"{i // 2},a,{'-' * (i % 2)}0.0,2,3,4,5\n" for i in range(60)),
    "a formula": changed(30, "3,'=1+1,1,2,3,4,5\n"),
}


def read(text: str, path: Path) -> object:
    path.write_text(text, encoding="utf-8", newline="")
    try:
        recording, report = read_recording([NamedFile("marks.csv", path)], limits=ReadLimits(max_rows=60))
    except InputError as error:
        return error.code, error.message
    return {name: array.tobytes() for name, array in recording.to_arrays().items()}, report


@pytest.mark.parametrize("case", CASES)
def test_both_ways_read_the_same(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    slowly = read(CASES[case], tmp_path / "marks.csv")
    monkeypatch.setattr(records, "WORTHWHILE_BYTES", 1)
    monkeypatch.setattr(regular_blocks, "BLOCK_BYTES", 500)
    assert read(CASES[case], tmp_path / "marks.csv") == slowly


@pytest.mark.parametrize("block", [100, 500, 10**6])
def test_of_too_many_rows_the_first_are_read_in_blocks_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, block: int
) -> None:
    slowly = read(HEADER + "".join(rows(75)), tmp_path / "marks.csv")
    monkeypatch.setattr(records, "WORTHWHILE_BYTES", 1)
    monkeypatch.setattr(regular_blocks, "BLOCK_BYTES", block)
    assert read(HEADER + "".join(rows(75)), tmp_path / "marks.csv") == slowly
    arrays, report = slowly  # type: ignore[misc]
    assert (report.rows_read, report.warnings[0].code) == (60, "rows_beyond_limit")
    assert arrays == read(HEADER + "".join(rows(60)), tmp_path / "marks.csv")[0]  # type: ignore[index]


def test_only_the_block_with_the_odd_line_is_read_line_by_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regular_blocks, "BLOCK_BYTES", 30)
    text = b"".join(b"%d,x\n" % i if i != 12 else b"12\n" for i in range(30))
    blocks = list(read_blocks(io.BytesIO(text), Layout(",", 2), 2))
    assert {type(block) for block in blocks} == {RegularBlock, OtherBlock}
    lines: list[tuple[int, list[str]]] = []
    for block in blocks:
        if isinstance(block, OtherBlock):
            lines += block.records(",")
        else:
            lines += [(block.line + i, list(cells)) for i, cells in enumerate(zip(*block.columns, strict=True))]
    assert lines == [(i + 2, [str(i), "x"] if i != 12 else ["12"]) for i in range(30)]


def test_no_line_is_longer_than_is_told_and_not_by_much(tmp_path: Path) -> None:
    stretch = 1 << 16
    long = b"c" * (3 * stretch)
    for text, longest in (
        (b"ab\n" * 200_000, 3),
        (b"ab\n" + long + b"\nd\n", len(long)),
        (b"ab\n" * 400_000 + long, len(long)),
        (b"a\n" * 10 + b"d", 2),
    ):
        path = tmp_path / "text.csv"
        path.write_bytes(text)
        told = inspect(NamedFile("text.csv", path), ReadLimits(), Findings()).longest_line
        assert longest <= told <= longest + 2 * stretch, text[:10]


def test_blocks_keep_their_order_and_an_end_without_a_line_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regular_blocks, "BLOCK_BYTES", 64)
    text = b"\n".join(b"%d,%d" % (i, -i) for i in range(500))
    blocks = list(read_blocks(io.BytesIO(text), Layout(",", 2, frozenset({0})), 1))
    assert all(isinstance(block, RegularBlock) for block in blocks)
    regular = [block for block in blocks if isinstance(block, RegularBlock)]
    assert np.concatenate([block.columns[0] for block in regular]).tolist() == list(range(500))
    assert [cell for block in regular for cell in block.columns[1]] == [str(-i) for i in range(500)]
    assert [block.line for block in regular] == np.cumsum([1, *map(len, regular)]).tolist()[:-1]
