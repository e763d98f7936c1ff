"""Colours, dashes and symbols of the charts, for the light theme; the page re-colours by role for the dark one."""

from __future__ import annotations

# Safe for colour-blind people, on both themes, in this order.
SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
# Each colour comes with a dash and a symbol, so that no entry is told by colour alone.
DASHES = ("solid", "dash", "dashdot", "longdash", "dot", "longdashdot")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "pentagon")

SURFACE = "#ffffff"
TEXT = "#1f2328"
GRID = "#e3e6ea"
AXIS = "#8a929b"
TRUTH = TEXT
STATION = TEXT
MEASUREMENT = "rgba(110,118,129,0.4)"
BOUND = "#8a929b"
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
# Few to many: shares of receptions, one hue so that the order can be seen without a legend.
SEQUENCE = ("#f0f4f8", "#c9dcec", "#94bfdd", "#5a9bc8", "#2a77ae", "#0b4f82")

INTERVAL_OPACITY = 0.18
# True paths of so few points have a dot at each: a target seen once has no line. More dots would hide the tracks.
DOTTED_TRUTH = 500


def series_color(index: int) -> str:
    """Colour of the entry at this place."""
    return SERIES[index % len(SERIES)]


def series_dash(index: int) -> str:
    """Dash of the entry at this place; the second round of colours gets other dashes than the first."""
    return DASHES[(index + index // len(SERIES)) % len(DASHES)]


def series_symbol(index: int) -> str:
    """Symbol of the entry at this place."""
    return SYMBOLS[(index + index // len(SERIES)) % len(SYMBOLS)]


def faint(color: str, opacity: float) -> str:
    """The same colour, given as #rrggbb, let through to this degree."""
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},{opacity:g})"
