"""Units that a column may be in, and how they become SI (seconds, metres, radians, hertz, metres per second)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from algorithms.errors import InputError
from algorithms.recording import Floats

Dimension = Literal["time", "length", "angle", "frequency", "frequency rate", "speed"]


@dataclass(frozen=True)
class Unit:
    """value in SI = value * factor / divisor. The divisor keeps powers of ten exact: x / 1e9, never x * 1e-9."""

    dimension: Dimension
    factor: float = 1.0
    divisor: float = 1.0

    def to_si(self, values: Floats) -> Floats:
        """Convert to SI."""
        if self.factor != 1.0:
            values = values * self.factor
        return values / self.divisor if self.divisor != 1.0 else values


UNITS: dict[str, Unit] = {
    "s": Unit("time"),
    "ms": Unit("time", divisor=1e3),
    "us": Unit("time", divisor=1e6),
    "ns": Unit("time", divisor=1e9),
    "min": Unit("time", factor=60.0),
    "h": Unit("time", factor=3600.0),
    "m": Unit("length"),
    "km": Unit("length", factor=1e3),
    "ft": Unit("length", factor=0.3048),
    "FL": Unit("length", factor=30.48),
    "NM": Unit("length", factor=1852.0),
    "deg": Unit("angle", factor=math.pi, divisor=180.0),
    "rad": Unit("angle"),
    "mrad": Unit("angle", divisor=1e3),
    "turn": Unit("angle", factor=2 * math.pi),
    # Radars count the turn of their antenna in parts of a power of two.
    "turn/65536": Unit("angle", factor=2 * math.pi, divisor=65536.0),
    "Hz": Unit("frequency"),
    "kHz": Unit("frequency", factor=1e3),
    "MHz": Unit("frequency", factor=1e6),
    "Hz/s": Unit("frequency rate"),
    "m/s": Unit("speed"),
    "km/h": Unit("speed", divisor=3.6),
    "kn": Unit("speed", factor=1852.0, divisor=3600.0),
    "ft/min": Unit("speed", factor=0.3048, divisor=60.0),
}

# Longest suffix first: `_hz_s` is a rate and no time.
_SUFFIXES = (
    ("_hz_s", "Hz/s"),
    ("_mps", "m/s"),
    ("_deg", "deg"),
    ("_hz", "Hz"),
    ("_ns", "ns"),
    ("_m", "m"),
    ("_s", "s"),
)


def native_unit(name: str) -> str:
    """Unit that stands at the end of a native column's name."""
    return next(unit for suffix, unit in _SUFFIXES if name.endswith(suffix))


def unit_for(name: str, unit: str | None, pointer: str) -> Unit:
    """Unit of the column that serves as the native column `name`.

    Raises InputError where the unit is unknown or measures something else.
    """
    native = UNITS[native_unit(name)]
    if unit is None:
        return native
    found = UNITS.get(unit) or next((u for n, u in UNITS.items() if n.lower() == unit.lower()), None)
    if found is None or found.dimension != native.dimension:
        fitting = ", ".join(n for n, u in UNITS.items() if u.dimension == native.dimension)
        raise InputError(
            f"{unit!r} is no unit for {name}, which is a {native.dimension}.",
            pointer=pointer,
            remedy=f"Use one of {fitting}.",
            code="unit",
        )
    return found
