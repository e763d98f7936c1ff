"""How fast ASTERIX is read: CAT 048 with the marks of CAT 034, 100 aircraft, each size in a process of its own.

Prints records a second of processor time once the decoder is loaded, the growth from size to size, and peak memory.
Run: uv run --group dev python benchmarks/asterix.py [--records 10000 100000 1000000]
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# In place of this folder, in which this file has the name of the decoder.
sys.path[0] = str(ROOT)

AIRCRAFT = 100
PERIOD_S = 4.0
# Records that libasterix writes itself, 100 turns; longer recordings repeat them with later times.
WRITTEN = 10_000
# In a record of CAT 048: category, length, two octets of FSPEC, data source; then the time of day.
TIME_AT = 1 + 2 + 2 + 2
TICKS = 128


def turns() -> list[bytes]:
    """Data blocks in order of time: a north mark and a plot of each aircraft, turn by turn."""
    from tests.asterix_files import cat048, north, plot

    out = []
    for turn in range(WRITTEN // AIRCRAFT):
        out.append(north(turn * PERIOD_S))
        for k in range(AIRCRAFT):
            azimuth = (360.0 * k / AIRCRAFT + 0.02 * turn) % 360
            at = (turn + azimuth / 360) * PERIOD_S
            more = {"address": 0x400000 + k, "callsign": f"FLT{k:04d}", "level": 100 + k, "squawk": 0o1000 + k}
            out.append(cat048(plot(at, 20 + k + 0.05 * turn, azimuth, **more)))
    return out


def later(block: bytes, ticks: int) -> bytes:
    """The same block with another time of day."""
    return (
        block[:TIME_AT]
        + (int.from_bytes(block[TIME_AT : TIME_AT + 3], "big") + ticks).to_bytes(3, "big")
        + block[TIME_AT + 3 :]
    )


def write(path: Path, records: int) -> int:
    """Write a recording of so many plots; return how many records it has with the marks."""
    from tests.asterix_files import north

    one = turns()
    span = WRITTEN // AIRCRAFT * PERIOD_S
    total = 0
    with path.open("wb") as out:
        for copy in range(-(-records // WRITTEN)):
            for block in one:
                if block[0] == 34:
                    seconds = copy * span + (total // (AIRCRAFT + 1)) % (WRITTEN // AIRCRAFT) * PERIOD_S
                    out.write(north(seconds))
                else:
                    out.write(later(block, round(copy * span * TICKS)))
                total += 1
    return total


def read(path: Path) -> dict[str, float]:
    """Read a recording in this process, which reads nothing else."""
    from backend.files.options import ReadLimits
    from backend.files.reading import NamedFile, read_recording

    small = path.with_name("small.ast")
    began = time.process_time()
    read_recording([NamedFile("small.ast", small)])
    loaded = time.process_time()
    _, report = read_recording([NamedFile(path.name, path)], limits=ReadLimits())
    done = time.process_time()
    rejected = len(report.rejections)
    return {
        "load_s": loaded - began,
        "read_s": done - loaded,
        "records": report.rows_read,
        "accepted": report.rows_accepted,
        "rejected": rejected,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def main() -> None:
    """Write, read, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, nargs="+", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--read", type=Path)
    options = parser.parse_args()
    if options.read:
        print(json.dumps(read(options.read)))
        return
    widths = {"plots": 9, "MB": 6, "load, s": 8, "read, s": 8, "records/s": 10, "growth": 7, "peak, MB": 9, "told": 22}
    print(" ".join(f"{name:>{width}}" for name, width in widths.items()))
    before: tuple[int, float] | None = None
    with tempfile.TemporaryDirectory() as folder:
        small = Path(folder) / "small.ast"
        small.write_bytes(b"".join(turns()[: AIRCRAFT + 1]))
        for size in options.records:
            path = Path(folder) / "recording.ast"
            write(path, size)
            command = [sys.executable, __file__, "--read", str(path)]
            found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
            # Linear growth is 1: the time of one record beside that of the size before.
            each = found["read_s"] / found["records"]
            growth = "" if before is None else f"{each / before[1]:.2f}"
            before = (size, each)
            told = f"{found['accepted']:,} + {found['rejected']:,}"
            print(
                f"{size:9,} {path.stat().st_size / 1e6:6.1f} {found['load_s']:8.2f} {found['read_s']:8.2f} "
                f"{1 / each:10,.0f} {growth:>7} {found['peak_mb']:9.0f} {told:>22}"
            )


if __name__ == "__main__":
    main()
