"""What the user may say about how a file is to be read, and the limits that the server sets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from algorithms.recording import Kind
from algorithms.site import Origin


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)


class ColumnSource(_Model):
    """Where one native column comes from in a foreign CSV."""

    column: Annotated[str, Field(min_length=1, max_length=200)]
    unit: Annotated[str, Field(max_length=20)] | None = None
    """Unit of the source column; without it the unit in the native name holds."""
    minus: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Another column that is subtracted first: the radar's own position from a plot in a fixed frame."""


def _source(value: Any) -> Any:
    return {"column": value} if isinstance(value, str) else value


def _utc(value: Any) -> Any:
    if value is None:
        return None
    moment = value if isinstance(value, datetime) else None
    if isinstance(value, str):
        try:
            moment = datetime.fromisoformat(value.strip())
        except ValueError as e:
            raise ValueError("give a date and time such as 2026-03-01T12:00:00Z") from e
    if moment is None:
        raise ValueError("give a date and time such as 2026-03-01T12:00:00Z")
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    return moment.astimezone(UTC).isoformat().replace("+00:00", "Z")


Source = Annotated[ColumnSource, BeforeValidator(_source)]
WhereValue = bool | int | float | str


class ReadOptions(_Model):
    """How to read an upload. Everything is optional: format and kind are detected from the content."""

    name: Annotated[str, Field(max_length=200)] | None = None
    """Name of the recording; by default that of the first file."""
    kind: Kind | None = None
    """Kind of the measurements, where the columns leave it open."""
    format: Annotated[str, Field(max_length=40)] | None = None
    """Name of a reader, where the content leaves it open."""
    mapping: Annotated[dict[str, Source], Field(max_length=500)] = {}
    """Native column name -> column (and unit) of the file."""
    truth_mapping: Annotated[dict[str, Source], Field(max_length=50)] = {}
    """The same for the truth file."""
    where: Annotated[dict[str, WhereValue], Field(max_length=20)] = {}
    """Only rows whose columns hold these values are read."""
    origin: Origin | None = None
    """WGS-84 origin of the local frame."""
    start_utc: Annotated[str | None, BeforeValidator(_utc)] = None
    """The instant from which `time_s` counts."""
    truth_shift_s: Annotated[float, Field(ge=-86_400, le=86_400)] = 0.0
    """Seconds added to the times of the truth file, whose clock is slow by so much."""
    edition: Annotated[str, Field(max_length=40)] | None = None
    """Edition of a binary format's specification: "1.30", or by ASTERIX category "48:1.30 34:1.27"."""
    scan_cut: Literal["marks", "azimuth", "period"] | None = None
    """How plots are parted into scans: by marks of the antenna in the file, by azimuth, or in equal slices of time."""
    scan_period_s: Annotated[float, Field(gt=0, le=3600)] | None = None
    """Seconds of one turn of the antenna."""
    order: Literal["sort", "reject"] = "sort"
    """What happens to rows that are earlier than one before them."""
    equal_times: Literal["reject", "average"] = "reject"
    """What happens to a Doppler that is measured again at the same instant."""

    def columns(self) -> frozenset[str]:
        """Columns of the file that the user named."""
        return columns_of(self.mapping, self.where)


def columns_of(mapping: Mapping[str, ColumnSource], where: Mapping[str, WhereValue]) -> frozenset[str]:
    """Columns of a file that a mapping and a filter name."""
    named = {s.column for s in mapping.values()} | {s.minus for s in mapping.values() if s.minus is not None}
    return frozenset(named | set(where))


@dataclass(frozen=True)
class ReadLimits:
    """How much one upload may ask for."""

    max_rows: int = 5_000_000
    max_expanded_bytes: int = 1 << 30
    """Size of what a packed file unpacks to."""
    max_expansion: float = 200.0
    """Unpacked over packed size of a packed file (measurements in text pack 3 to 20 times)."""
