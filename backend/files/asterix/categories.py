"""What the categories that are read mean: which items hold the time, the position, the identity.

A role names one or several places, of which the first that a record has counts. A place that an edition does not
have is passed over, so old editions of CAT 021 need no table of their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Path = tuple[str, ...]


@dataclass(frozen=True)
class Category:
    """One category that is read.

    Attributes
    ----------
    number : of the category
    use : `plots` of a radar, `service` messages of a radar (north marks, sectors), or `reference`: positions that
        something better than one radar tells
    places : role -> items and subitems
    """

    number: int
    use: str
    places: Mapping[str, tuple[Path, ...]] = field(repr=False)

    @property
    def word(self) -> str:
        """Its name in texts."""
        return f"CAT {self.number:03d}"


_SOURCE = {"sac": (("010", "SAC"),), "sic": (("010", "SIC"),)}
_MODE_3A = {
    "mode_3a": (("070", "MODE3A"),),
    "mode_3a_unsure": (("070", "V"),),
    "mode_3a_garbled": (("070", "G"),),
}
_LEVEL_FLAGS = {"level_unsure": (("090", "V"),), "level_garbled": (("090", "G"),)}
_POLAR = {"range": (("040", "RHO"),), "azimuth": (("040", "THETA"), ("040", "TH"))}
_XY = {"x": (("042", "X"),), "y": (("042", "Y"),)}
_MESSAGE = {"message": (("000",),)}
_ROTATION = {"sector": (("020",),), "period": (("041",),)}

_PLACES: dict[int, tuple[str, Mapping[str, tuple[Path, ...]]]] = {
    48: (
        "plots",
        {
            **_POLAR,
            **_XY,
            **_MODE_3A,
            **_LEVEL_FLAGS,
            "time": (("140",),),
            "level": (("090", "FL"),),
            "height": (("110", "3DH"),),
            "address": (("220",),),
            "identification": (("240",),),
            "simulated": (("020", "SIM"),),
            "test": (("020", "TST"),),
        },
    ),
    1: (
        "plots",
        {
            **_POLAR,
            **_XY,
            **_MODE_3A,
            **_LEVEL_FLAGS,
            "truncated_time": (("141",),),
            "level": (("090", "HGT"),),
            "simulated": (("020", "SIM"),),
            "test": (("020", "TST"),),
        },
    ),
    10: (
        "plots",
        {
            **_POLAR,
            **_XY,
            **_MESSAGE,
            **_LEVEL_FLAGS,
            "time": (("140",),),
            "mode_3a": (("060", "MODE3A"),),
            "mode_3a_unsure": (("060", "V"),),
            "mode_3a_garbled": (("060", "G"),),
            "level": (("090", "FL"),),
            "address": (("220",),),
            "identification": (("245", "CHR"),),
            "test": (("020", "TST"),),
        },
    ),
    34: (
        "service",
        {
            **_MESSAGE,
            **_ROTATION,
            "time": (("030",),),
            "latitude": (("120", "LAT"),),
            "longitude": (("120", "LON"),),
            "height": (("120", "HGT"),),
        },
    ),
    2: ("service", {**_MESSAGE, **_ROTATION, "time": (("030",),)}),
    20: (
        "reference",
        {
            **_XY,
            **_MODE_3A,
            **_LEVEL_FLAGS,
            "time": (("140",),),
            "latitude": (("041", "LAT"),),
            "longitude": (("041", "LON"),),
            "level": (("090", "FL"),),
            "height": (("105",),),
            "address": (("220",),),
            "identification": (("245", "CHR"),),
            "track": (("161", "TRN"),),
            "simulated": (("020", "SIM"),),
            "test": (("020", "TST"),),
        },
    ),
    21: (
        "reference",
        {
            "time": (("073",), ("071",), ("030",), ("077",)),
            "latitude": (("131", "LAT"), ("130", "LAT")),
            "longitude": (("131", "LON"), ("130", "LON")),
            "level": (("145",),),
            "height": (("140",),),
            "address": (("080",),),
            "mode_3a": (("070", "MODE3A"),),
            "identification": (("170",),),
            "track": (("161", "TRNUM"),),
            "simulated": (("040", "SIM"),),
            "test": (("040", "TST"),),
        },
    ),
    62: (
        "reference",
        {
            "time": (("070",),),
            "latitude": (("105", "LAT"),),
            "longitude": (("105", "LON"),),
            "x": (("100", "X"),),
            "y": (("100", "Y"),),
            "velocity_x": (("185", "VX"),),
            "velocity_y": (("185", "VY"),),
            "level": (("136",),),
            "height": (("130",),),
            "address": (("380", "ADR"),),
            "mode_3a": (("060", "MODE3A"),),
            "identification": (("380", "ID"), ("245", "CHR")),
            "track": (("040",),),
        },
    ),
}

CATEGORIES = {n: Category(n, use, {**_SOURCE, **places}) for n, (use, places) in _PLACES.items()}
"""What is read, by number. Blocks of other categories are counted and left out."""
