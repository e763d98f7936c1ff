"""What is left in English on a Russian page."""

from __future__ import annotations

import re
from collections.abc import Iterable

from playwright.sync_api import Page

# Names: of the program, of formats, of methods and quantities as the papers write them, of choices in parameters.
_NAMES = (
    "Filter Room|CSV|JSON|HTML|PNG|SVG|SHA|UTC|WGS|API|curl|Python|LocaRDS|Parquet|MATLAB|NIS|NEES|DOI|HDF|"
    "PARQUET|MAT|NPZ|GEOJSON|NumPy|ASTERIX|KML|GeoJSON|"
    "rdfv?|RDFV?|DRMS|GDOP|Ctrl|Shift|Enter|Esc|MIT|Windows|white|paper|robust|article|sphere|wgs84|auto|given|truth|nis|nees|none|info|"
    "unused|held|corrected"
)
# What a sweep writes into a label is what scripts call it: predictor = line.
_KNOWN = re.compile(rf"\b(?:{_NAMES})\b|\w+ = [\w.]+|\S*[_.\d{{}}]\S*")
_WORD = re.compile(r"[A-Za-z]{3,}")

_TEXTS = """() => {
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const { data, parentElement: at } = walker.currentNode;
    if (!at.closest('code, kbd, pre.card, script, style, noscript') && at.checkVisibility()) found.push(data);
  }
  for (const name of ['title', 'aria-label', 'placeholder', 'aria-valuetext'])
    for (const at of document.querySelectorAll(`[${name}]`))
      // The hint of a table's row is the name that scripts use.
      if (at.checkVisibility() && !at.matches('th[scope=row]')) found.push(at.getAttribute(name));
  return [document.title, ...found];
}"""


def english_left(page: Page, names: Iterable[str] = ()) -> list[str]:
    """Every visible text, label and hint with an English word that is no name; `names` are those of the data."""
    left = []
    for text in page.evaluate(_TEXTS):
        rest = text
        for name in names:
            rest = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", "", rest)
        if _WORD.search(_KNOWN.sub("", rest)):
            left.append(text.strip())
    return left
