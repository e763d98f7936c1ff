"""A site says what is wrong with it before anything is computed from it."""

import numpy as np
import pytest
from pydantic import ValidationError

from algorithms.site import Site

A = {"name": "a", "east_m": 0, "north_m": 0, "up_m": 5}
B = {"name": "b", "east_m": 1000, "north_m": 0, "up_m": 5}


@pytest.mark.parametrize(
    ("site", "words"),
    [
        ({"stations": [A]}, "at least two"),
        ({"stations": [A, A]}, "repeats the name"),
        ({"stations": [A, {**A, "name": "c"}]}, "same place"),
        ({"stations": [A, {"name": "g", "latitude_deg": 50, "longitude_deg": 8}]}, "origin is needed"),
        ({"stations": [A, {"name": "x", "east_m": 1}]}, "complete"),
        ({"stations": [A, {**B, "latitude_deg": 1, "longitude_deg": 2}]}, "one of the two"),
        ({"stations": [A, {**B, "east_m": float("nan")}]}, "finite number"),
        ({"stations": [A, {**B, "sigma_toa_ns": 0}]}, "greater than 0"),
        ({"stations": [A, B], "colour": "red"}, "Extra inputs"),
    ],
)
def test_refused(site: dict, words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        Site.model_validate(site)


def test_one_far_receiver_does_not_move_the_origin() -> None:
    places = [(50.0, 8.0), (50.2, 8.1), (49.9, 8.2), (50.1, 7.9), (20.0, -60.0)]
    site = Site.model_validate(
        {"stations": [{"name": str(i), "latitude_deg": a, "longitude_deg": b} for i, (a, b) in enumerate(places)]}
    )
    origin = site.frame_origin()
    assert origin is not None
    assert abs(origin.latitude_deg - 50) < 0.3
    assert abs(origin.longitude_deg - 8) < 0.3
    assert np.isfinite(site.station_positions()).all()


def test_json_round_trip() -> None:
    site = Site.model_validate(
        {"origin": {"latitude_deg": 1, "longitude_deg": 2}, "stations": [A, B], "sigma_toa_ns": 9}
    )
    assert Site.model_validate(site.to_json()) == site
