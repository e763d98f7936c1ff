"""How accurate one mark can be, and where: the bound over a plan for any site, with and without altitude, by subset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import APIRouter, Response
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from algorithms.multilateration.parameters import SIGMA_ALTITUDE_M, SIGMA_TOA_NS
from algorithms.site import Site
from backend.api.responses import problems
from backend.api.scenario_request import checked_scenario
from backend.api.services import Services, ServicesDep
from backend.http.problems import ProblemError, ProblemItem

router = APIRouter(prefix="/accuracy-map", tags=["accuracy map"])

Floats = NDArray[np.float64]
Variant = Literal["space", "altitude_measured", "altitude_known", "altitude_gain", "clock"]

# Cells of one map, and cells over all subsets of stations: half a second of work each.
MOST_CELLS = 250_000
MOST_SUBSET_CELLS = 12_000_000
# Around the stations, in their own greatest distance from their middle, and at least so many metres.
REACH, LEAST_REACH_M = 5.0, 20_000.0


class _In(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


class AxisIn(_In):
    """Equal steps from one end of the map to the other."""

    start_m: Annotated[float, Field(ge=-2e6, le=2e6)]
    stop_m: Annotated[float, Field(ge=-2e6, le=2e6)]
    count: Annotated[int, Field(ge=2, le=1000)]

    @model_validator(mode="after")
    def _forward(self) -> AxisIn:
        if not self.stop_m > self.start_m:
            raise ValueError("stop_m must be above start_m")
        return self


class ScenarioSiteIn(_In):
    """The site of a preset."""

    preset: Annotated[str, Field(max_length=80)]
    parameters: dict[str, Any] = {}


class AccuracyMapIn(_In):
    """Whose stations, at which altitude, and what is to be drawn. One of `site`, `recording_id`, `scenario`."""

    site: dict[str, Any] | None = None
    """Site JSON with stations."""
    recording_id: Annotated[str, Field(max_length=80)] | None = None
    """A recording whose site is used."""
    scenario: ScenarioSiteIn | None = None
    """A preset whose site is used."""
    stations: Annotated[list[str], Field(max_length=200)] | None = None
    """Names of the stations that receive; default: all."""
    variant: Variant = "space"
    """Bound of a position in space; with a measured or a known altitude; how much a known altitude gains; how far a
    nanosecond of the clock of the worst station moves the fix with a measured altitude."""
    quantity: Literal["drms_m", "gdop"] = "drms_m"
    """Metres, or metres for a metre of rms error of the arrivals (`gdop`)."""
    altitude_m: Annotated[float, Field(ge=-500, le=100_000)] = 10_000.0
    """Altitude of the emitter."""
    sigma_toa_ns: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Standard deviation of each arrival; default: that of each station, of the site, 10."""
    sigma_altitude_m: Annotated[float, Field(gt=0, le=1e5)] | None = None
    """Standard deviation of the measured altitude; default: that of the site, 100."""
    east_m: AxisIn | None = None
    """Default: 200 steps around the stations, as `north_m`."""
    north_m: AxisIn | None = None
    subsets: bool = False
    """Also say for each subset of the stations (of three and more; of more than six stations: all, without one, without
    two) where it sees and how well."""

    @model_validator(mode="after")
    def _one_site(self) -> AccuracyMapIn:
        if sum(x is not None for x in (self.site, self.recording_id, self.scenario)) != 1:
            raise ValueError("give exactly one of site, recording_id, scenario")
        return self


class _Out(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class SubsetOut(_Out):
    """What some of the stations can do."""

    stations: list[str]
    observable_share: float
    """Of the cells of the map."""
    median: float | None
    """Over the observable cells."""
    quantile_90: float | None
    """Over the observable cells."""
    common_ratio: float | None
    """Median ratio to the map of the chosen stations, over the cells that both see; above 1 is worse."""


class PlaceOut(_Out):
    """A station in the local frame."""

    name: str
    east_m: float
    north_m: float
    up_m: float


class ClockOut(_Out):
    """How far a nanosecond of a station's clock moves the fix."""

    station: str
    median_m_per_ns: float | None
    largest_m_per_ns: float | None


class AccuracyMapOut(_Out):
    """The map as numbers and as a chart. `POST` answers with it; numbers as base64 typed arrays."""

    variant: Variant
    quantity: str
    unit: str
    stations: list[str]
    """Those that receive."""
    site: dict[str, Any]
    places: list[PlaceOut]
    """Where its stations stand in the local frame."""
    origin: dict[str, float] | None
    """WGS-84 origin of the local frame, where the site has one."""
    altitude_m: float
    sigma_toa_ns: dict[str, float]
    sigma_altitude_m: float
    east_m: AxisIn
    north_m: AxisIn
    values: dict[str, Any]
    """(north, east) float32; NaN where the position is not observable."""
    observable_share: float
    median: float | None
    chart: dict[str, Any]
    clocks: list[ClockOut]
    """With a measured altitude; stations that receive."""
    subsets: list[SubsetOut] | None


@router.post(
    "",
    name="accuracy_map",
    response_class=Response,
    responses={200: {"model": AccuracyMapOut, "description": "The map"}, **problems(404, 413, 415)},
)
def accuracy_map(asked: AccuracyMapIn, services: ServicesDep) -> Response:
    """Compute the Cramer-Rao bound of one mark at every place of a plan; nothing is stored.

    A 200 x 200 map takes about 20 ms, so that a page can follow a station that is dragged.
    """
    from algorithms.toolbox.bounds import accuracy_map as bounds
    from backend.charts import accuracy_map as chart
    from backend.charts.figure import ChartNote, figure_json

    site = _site(asked, services)
    names = [s.name for s in site.stations]
    chosen = _chosen(asked, names)
    positions = site.station_positions()
    own_or_sites = [asked.sigma_toa_ns or s.sigma_toa_ns or site.sigma_toa_ns or SIGMA_TOA_NS for s in site.stations]
    sigma_ns = np.array(own_or_sites)
    sigma_m = sigma_ns * bounds.C_M_PER_NS
    sigma_altitude_m = asked.sigma_altitude_m or site.sigma_altitude_m or SIGMA_ALTITUDE_M
    east_axis, north_axis = _axes(asked, positions)
    cells = east_axis.count * north_axis.count
    sets = bounds.subsets(len(names)) if asked.subsets else []
    if cells > MOST_CELLS or len(sets) * cells > MOST_SUBSET_CELLS:
        detail = (
            f"The map has {cells} cells and {max(len(sets), 1)} subsets of stations; there may be {MOST_CELLS} cells, "
            f"and {MOST_SUBSET_CELLS} over all subsets. Lower `count` of the axes."
        )
        raise _refused(413, "map_too_large", "/east_m/count", detail)
    east, north = (np.linspace(a.start_m, a.stop_m, a.count) for a in (east_axis, north_axis))
    grid_east, grid_north = (g.ravel() for g in np.meshgrid(east, north))
    is_gdop = asked.quantity == "gdop"
    places = bounds.places_at(grid_east, grid_north, asked.altitude_m, _earth(site))

    def plan(which: Sequence[int]) -> Floats:
        at = list(which)
        return bounds.plan_values(places, positions[at], sigma_m[at], asked.variant, sigma_altitude_m, as_gdop=is_gdop)

    values = plan(chosen)
    summary = bounds.summary_of(values)
    clocks = bounds.plan_bound(places, positions[chosen], sigma_m[chosen], "measured", sigma_altitude_m, clocks=True)
    assert clocks.clock_m_per_ns is not None
    by_station = [bounds.summary_of(moved) for moved in clocks.clock_m_per_ns]

    def subset(which: Sequence[int]) -> dict[str, Any]:
        own = plan(which)
        found = bounds.summary_of(own)
        return {
            "stations": [names[i] for i in which],
            "observable_share": found.observable_share,
            "median": found.median,
            "quantile_90": found.quantile_90,
            "common_ratio": bounds.summary_of(own / values).median,
        }

    unit, quantity = _words(asked.variant, asked.quantity)
    receiving = [names[i] for i in chosen]
    note = f"Emitter at {asked.altitude_m:g} m; one mark, received by {', '.join(receiving)}."
    shown = {
        "variant": asked.variant,
        "quantity": asked.quantity,
        "unit": unit,
        "stations": receiving,
        "site": site.to_json(),
        "places": [
            {"name": name, "east_m": e, "north_m": n, "up_m": u}
            for name, (e, n, u) in zip(names, positions.tolist(), strict=True)
        ],
        "origin": None if (origin := site.frame_origin()) is None else origin.model_dump(),
        "altitude_m": asked.altitude_m,
        "sigma_toa_ns": dict(zip(names, sigma_ns.tolist(), strict=True)),
        "sigma_altitude_m": sigma_altitude_m,
        "east_m": east_axis.model_dump(),
        "north_m": north_axis.model_dump(),
        "values": values.reshape(north.size, east.size).astype(np.float32),
        "observable_share": summary.observable_share,
        "median": summary.median,
        "chart": chart.draw(
            east,
            north,
            values.reshape(north.size, east.size),
            title=quantity,
            quantity=quantity,
            unit=unit,
            stations_m=positions,
            names=names,
            used=[i in chosen for i in range(len(names))],
            notes=[ChartNote("one_mark", note)],
        ),
        "clocks": [
            {"station": name, "median_m_per_ns": one.median, "largest_m_per_ns": one.largest}
            for name, one in zip(receiving, by_station, strict=True)
        ],
        "subsets": [subset(which) for which in sets] if asked.subsets else None,
    }
    return Response(figure_json(shown), media_type="application/json")


def _words(variant: Variant, quantity: str) -> tuple[str, str]:
    if variant == "altitude_gain":
        return "", "Gain of a known altitude"
    if variant == "clock":
        return "m/ns", "Shift by the clock of the worst station"
    return ("", "GDOP") if quantity == "gdop" else ("m", "DRMS of one mark")


def _site(asked: AccuracyMapIn, services: Services) -> Site:
    from backend.api import uploads

    if asked.scenario is not None:
        site = checked_scenario(asked.scenario.preset, asked.scenario.parameters, "/scenario")[2].site
    elif asked.recording_id is not None:
        stored = uploads.ready(services, asked.recording_id).site
        site = None if stored is None else Site.model_validate(dict(stored))
    else:
        from backend.files.site_source import validated_site

        site = validated_site(dict(asked.site or {}))
    if site is None or len(site.stations) < 2:
        detail = "The site has no stations; a map of the accuracy of time differences needs two or more."
        raise _refused(422, "no_stations", "/site/stations", detail)
    return site


def _chosen(asked: AccuracyMapIn, names: list[str]) -> list[int]:
    if asked.stations is None:
        return list(range(len(names)))
    for k, name in enumerate(asked.stations):
        if name not in names:
            detail = f"There is no station {name!r}; there are {', '.join(names)}."
            raise _refused(422, "station_unknown", f"/stations/{k}", detail)
    chosen = [i for i, name in enumerate(names) if name in asked.stations]
    if len(chosen) < 2:
        detail = "Two stations are the fewest that measure a time difference."
        raise _refused(422, "too_few_stations", "/stations", detail)
    return chosen


def _axes(asked: AccuracyMapIn, positions: Floats) -> tuple[AxisIn, AxisIn]:
    middle = positions[:, :2].mean(axis=0)
    reach = max(REACH * float(np.linalg.norm(positions[:, :2] - middle, axis=1).max()), LEAST_REACH_M)
    own = [AxisIn(start_m=max(m - reach, -2e6), stop_m=min(m + reach, 2e6), count=200) for m in middle]
    return asked.east_m or own[0], asked.north_m or own[1]


def _earth(site: Site) -> Floats:
    from algorithms.toolbox.frames import earth

    origin = site.frame_origin()
    return earth.sphere() if origin is None else earth.wgs84(origin)


def _refused(status: int, code: str, pointer: str, detail: str) -> ProblemError:
    return ProblemError(status, code, detail, errors=[ProblemItem(pointer=pointer, detail=detail, code=code)])
