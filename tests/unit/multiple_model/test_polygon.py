"""Polygons of regions: what is one, and which two edges meet where it is none."""

from __future__ import annotations

import math

import pytest

from algorithms.errors import ParameterError
from algorithms.multiple_model.multiple_model import MultipleModelParameters
from algorithms.multiple_model.polygon import Corner, fault_of

SQUARE = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]


@pytest.mark.parametrize(
    "corners",
    [
        SQUARE,
        SQUARE[::-1],
        [*SQUARE, SQUARE[0]],
        [(0.0, 0.0), (0.0, 0.0), (5.0, 0.0), (10.0, 0.0), (3.0, 1.0)],
        # A comb whose box holds the boxes of most of its edges.
        [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (6.0, 1.0), (5.0, 9.0), (3.0, 1.0), (0.0, 9.0)],
        [(1e7 * math.cos(a / 30), 1e7 * math.sin(a / 30)) for a in range(180)],
        [(-1e7, -1e7), (1e7, -1e7 + 1e-3), (1e7, -1e7)],
    ],
)
def test_a_polygon(corners: list[Corner]) -> None:
    assert fault_of(corners) == ""


@pytest.mark.parametrize(
    ("corners", "edges"),
    [
        ([SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]], ("corner 1 to 2", "corner 3 to 4")),
        ([(0.0, 0.0), (10.0, 0.0), (5.0, 10.0), (5.0, -10.0)], ("corner 1 to 2", "corner 3 to 4")),
        # The edge that closes the polygon, which nobody typed, crosses the second.
        ([(0.0, 0.0), (4.0, 5.0), (9.0, -5.0), (9.0, 5.0)], ("corner 2 to 3", "corner 4 to 1")),
        # A corner on another edge, a corner used twice, an edge that goes back over its neighbour.
        ([(0.0, 0.0), (8.0, 0.0), (8.0, 4.0), (4.0, 0.0), (0.0, 4.0)], ("corner 1 to 2", "corner 3 to 4")),
        (
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 1.0)],
            ("corner 2 to 3", "corner 5 to 6"),
        ),
        ([(0.0, 0.0), (9.0, 0.0), (4.0, 0.0), (4.0, 5.0)], ("corner 1 to 2", "corner 2 to 3")),
    ],
)
def test_edges_that_meet_are_named(corners: list[Corner], edges: tuple[str, str]) -> None:
    fault = fault_of(corners)
    assert all(edge in fault for edge in edges), fault


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([(1.0, 2.0)], "1 distinct corners"),
        ([(1.0, 2.0)] * 4, "1 distinct corners"),
        ([(1.0, 2.0), (3.0, 4.0), (1.0, 2.0), (3.0, 4.0)], "2 distinct corners"),
        ([(0.1, 0.3), (0.2, 0.6), (0.3, 0.9), (0.7, 2.1)], "area is zero"),
    ],
)
def test_what_has_no_area_is_none(corners: list[Corner], words: str) -> None:
    assert words in fault_of(corners)


def test_the_region_is_named_with_the_remedy() -> None:
    models = ({"kind": "cv", "sigma_mps2": 1.0},)
    good = {"transition": ((1.0,),), "corners": SQUARE}
    bad = {"transition": ((1.0,),), "name": "bow", "corners": [SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]]}
    with pytest.raises(ParameterError, match=r"Region 2 'bow': the edge.*in order around the region") as caught:
        MultipleModelParameters.model_validate({"models": models, "transition": ((1.0,),), "regions": (good, bad)})
    assert (caught.value.pointer, caught.value.code) == ("/regions/1/corners", "region_polygon")
