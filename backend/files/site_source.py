"""The site that comes with an upload: Site JSON, or a sensor table in CSV from which a site is made."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from algorithms.errors import InputError
from algorithms.site import Site
from backend.files.columns import ColumnCollector, Faults
from backend.files.containers import open_rows
from backend.files.content import NamedFile, inspect
from backend.files.options import ColumnSource, ReadLimits
from backend.files.report import Findings, some
from backend.files.rows import require_column
from backend.files.selection import NameColumn, Quantity, Selection

_LARGEST_SITE_BYTES = 8 << 20
_TABLE_COLUMNS = ("serial", "latitude", "longitude", "height")


@dataclass(frozen=True)
class SensorTable:
    """WGS-84 positions (degrees, degrees, m) of stations by serial; None = in the table, but without a position."""

    positions: Mapping[str, tuple[float, float, float] | None] = field(default_factory=dict)


SiteSource = Site | SensorTable


def read_site(data: bytes, findings: Findings) -> SiteSource:
    """Read Site JSON or a sensor table.

    Raises InputError with a pointer below `/site`.
    """
    if not data.strip():
        raise InputError(
            "The site is empty.", pointer="/site", remedy="Give Site JSON or a sensor table.", code="empty_file"
        )
    if len(data) > _LARGEST_SITE_BYTES:
        raise InputError(
            "The site is larger than 8 MiB.",
            pointer="/site",
            remedy="Keep only the stations in use.",
            code="site_large",
        )
    first = data.removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    return _read_json(data) if first in (b"{", b"[") else _read_table(data, findings)


def _read_json(data: bytes) -> Site:
    try:
        return Site.model_validate_json(data.removeprefix(b"\xef\xbb\xbf"))
    except ValidationError as e:
        raise site_error(e) from e


def site_error(error: ValidationError) -> InputError:
    """The first problem of a site as one error with a JSON pointer, and how many more there are."""
    details = error.errors(include_url=False)
    first: ErrorDetails = details[0]
    message = first["msg"].removeprefix("Value error, ")
    more = f" ({len(details) - 1} more)" if len(details) > 1 else ""
    is_syntax = first["type"] == "json_invalid"
    field = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in first["loc"]).lstrip(".")
    return InputError(
        f"The site cannot be used, {field}: {message}{more}."
        if field
        else f"The site cannot be used: {message}{more}.",
        pointer="".join(f"/{step}" for step in ("site", *first["loc"])),
        remedy="Correct the JSON." if is_syntax else "A site is described in docs/formats.md.",
        code="site_json" if is_syntax else "site_invalid",
    )


def _read_table(data: bytes, findings: Findings) -> SensorTable:
    limits = ReadLimits(max_rows=100_000)
    own = Findings("the sensor table")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "sensors.csv"
        path.write_bytes(data)
        content = inspect(NamedFile("the sensor table", path), limits, own, pointer="/site")
        rows = open_rows(content, limits, pointer="/site")
        if not set(_TABLE_COLUMNS) & set(rows.names):
            raise InputError(
                f"The site is neither Site JSON nor a sensor table: its columns are {some(rows.names)}.",
                pointer="/site",
                remedy="Give the places of the stations or radars as JSON, or a table with the columns serial, "
                "latitude, longitude and height; measurements go into the recording itself.",
                code="missing_column",
            )
        for name in _TABLE_COLUMNS:
            require_column(rows, name, "/site")
        mapping = {
            "true_latitude_deg": ColumnSource(column="latitude"),
            "true_longitude_deg": ColumnSource(column="longitude"),
            "true_height_m": ColumnSource(column="height"),
        }
        quantities = (
            Quantity("true_latitude_deg", -90, 90, required=True),
            Quantity("true_longitude_deg", -180, 360, required=True),
            Quantity("true_height_m", required=True),
        )
        selection = Selection(rows, mapping, {}, "/site")
        collector = ColumnCollector(selection, quantities, (NameColumn("serial"),), own)
        for chunk in collector.chunks(limits.max_rows):
            collector.add(chunk, Faults())
        columns = collector.finish()
    if own.rejections:
        findings.warn(
            "sensor_rows_unusable",
            f"Rows of the sensor table that cannot be read: "
            f"{some(f'row {r.row}, {r.detail}' for r in own.rejections)}.",
            len(own.rejections),
        )
    findings.warnings += own.warnings
    names = columns.names["serial"]
    table: dict[str, tuple[float, float, float] | None] = {}
    repeated: list[str] = []
    places = zip(*(columns.number(q.name).tolist() for q in quantities), strict=True)
    for code, (latitude, longitude, height) in zip(columns.codes["serial"].tolist(), places, strict=True):
        if code < 0:
            continue
        name = names[code]
        # In these tables a station whose owner gave no position stands at zero, zero, zero.
        place = (
            None
            if (latitude, longitude, height) == (0, 0, 0)
            else (
                # Ten decimals are 0.01 mm, and hide the way to radians and back.
                round(math.degrees(latitude), 10),
                round(math.degrees(longitude), 10),
                height,
            )
        )
        if name in table and table[name] != place:
            repeated.append(name)
            place = None
        table[name] = place
    if repeated:
        findings.warn(
            "sensor_repeated",
            f"Stations with two different positions in the sensor table count as stations without a position: "
            f"{some(repeated)}.",
            len(repeated),
        )
    if not table:
        raise InputError(
            "The sensor table has no usable row.",
            pointer="/site",
            remedy="Give serial, latitude, longitude and height of each station.",
            code="no_usable_rows",
        )
    return SensorTable(table)


def validated_site(fields: dict[str, Any]) -> Site:
    """Build a site; raises InputError with a pointer below `/site` where it is not sound."""
    try:
        return Site.model_validate(fields)
    except ValidationError as e:
        raise site_error(e) from e
