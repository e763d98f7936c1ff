"""Records as libasterix's specifications lay them out, against libasterix itself."""

import random

import numpy as np
import pytest
from asterix.base import Bits, ParsingMode

from backend.files.asterix.categories import CATEGORIES
from backend.files.asterix.edition import Edition, editions_of
from backend.files.asterix.fields import field_of, identifications
from backend.files.asterix.layout import RecordLayout, UndecodableError
from tests.asterix_files import CAT, block, plot, source

LAYOUTS = [
    pytest.param(record, id=f"{category}-{edition.text}-{i}")
    for category in CATEGORIES
    for edition in map(Edition, editions_of(category).values())
    for i, record in enumerate(edition.records)
]


def walked(layout: RecordLayout, data: bytes) -> dict[str, int] | None:
    """Positions of the items and, under an empty name, the end of the first record of `data`; None where it is none."""
    behind = 0
    try:
        while data[behind] & 1:
            behind += 1
        behind += 1
        form = layout.forms.get(data[:behind]) or layout.form(data[:behind])
        found = [0, 0, behind]
        behind += form.lead
        for sizer, fixed in form.steps:
            behind = sizer(data, behind)
            found.append(behind)
            behind += fixed
    except (IndexError, UndecodableError):
        return None
    if behind > len(data):
        return None
    return {name: found[k] + offset for name, (k, offset) in form.places.items()} | {"": behind}


@pytest.mark.parametrize("record", LAYOUTS)
def test_random_octets_are_walked_as_libasterix_parses_them(record):
    chance = random.Random(7)
    layout = RecordLayout(record)
    decoded = 0
    for _ in range(12):
        fspec = bytes([chance.randrange(256) | 1, chance.randrange(256) & 0xFE])
        data = fspec + bytes(chance.choice((chance.randrange(256), chance.randrange(8))) for _ in range(90))
        parsed = record.parse(ParsingMode.StrictParsing, Bits.from_bytes(data))
        found = walked(layout, data)
        if isinstance(parsed, ValueError):
            assert found is None
            continue
        decoded += 1
        made, rest = parsed
        assert found is not None
        assert found[""] == len(data) - len(rest) // 8
        for name, item in made.items_regular.items():
            assert found[name] == item.unparse().bit_offset1 // 8, name
    assert decoded


def test_values_are_those_of_libasterix():
    data = block(48, plot(12.5, 101.25, 271.5, address=0x4B1234, level=-2.5, squawk="7701", callsign="SWR12AB"))
    record = CAT[48]["1.32"].cv_record
    octets = np.frombuffer(data + bytes(16), np.uint8)
    found = walked(RecordLayout(record), data[3:])

    def value(*path):
        return field_of(record, path).number(octets, np.array([found[path[0]] + 3]))[0]

    assert value("140") == 12.5
    assert value("040", "RHO") == 101.25 * 1852
    assert value("040", "THETA") == pytest.approx(np.radians(271.5), abs=5e-5)
    assert value("090", "FL") == pytest.approx(-250 * 0.3048)
    assert value("220") == 0x4B1234
    assert value("070", "MODE3A") == 0o7701
    assert value("020", "TYP") == 5
    # Test targets are told by the second part of item 020, which this record does not have.
    assert np.isnan(value("020", "TST"))
    code = field_of(record, ("240",)).raw(octets, np.array([found["240"] + 3]))
    assert identifications(code) == (pytest.approx([0]), ("SWR12AB",))


def test_subitems_of_a_compound_item():
    items = {"010": source(), "380": {"ADR": 0xABCDEF, "ID": "RAM1    ", "PUN": (0, 3)}}
    record = CAT[62]["1.21"].cv_record
    data = block(62, items)
    place = walked(RecordLayout(record), data[3:])["380"] + 3
    octets = np.frombuffer(data + bytes(16), np.uint8)
    where = np.array([place, -1])
    assert field_of(record, ("380", "ADR")).raw(octets, where).tolist() == [0xABCDEF, -1]
    assert identifications(field_of(record, ("380", "ID")).raw(octets, where)) == (pytest.approx([0, -1]), ("RAM1",))
    without = block(62, {"010": source(), "380": {"ID": "RAM1    "}})
    octets = np.frombuffer(without + bytes(16), np.uint8)
    place = walked(RecordLayout(record), without[3:])["380"] + 3
    assert field_of(record, ("380", "ADR")).raw(octets, np.array([place])).tolist() == [-1]
    assert field_of(record, ("380", "ID")).raw(octets, np.array([place]))[0] > 0


def test_places_that_an_edition_does_not_have():
    assert field_of(CAT[21]["0.26"].cv_record, ("131", "LAT")) is None
    assert field_of(CAT[48]["1.32"].cv_record, ("999",)) is None
