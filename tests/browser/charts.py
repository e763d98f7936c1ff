"""What a drawn chart holds, read from Plotly's own objects in the page."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from playwright.sync_api import Error, Locator, Page

_READ = """(panel) => {
  const gd = panel.querySelector('.plot');
  // Between two figures the plot is taken away for a moment.
  if (!gd?._fullLayout) return null;
  const full = gd._fullLayout;
  // In space the axes are those of the scene.
  const [x, y] = full.scene ? [full.scene.xaxis, full.scene.yaxis] : [full.xaxis, full.yaxis];
  const length = (trace) => trace.x ? trace.x.length : 0;
  return {
    traces: gd._fullData.map((t) => ({
      name: t.name, type: t.type, visible: t.visible !== false, points: length(t),
      role: t.meta?.role, label: t.meta?.label, rows: t.customdata ? Array.from(t.customdata, Number) : [],
      color: t.line?.color ?? t.marker?.color ?? t.meta?.dot?.colour,
    })),
    x_title: x.title.text, y_title: y.title.text,
    x_range: x.range, y_range: y.range, x_length: x._length, y_length: y._length,
    x_scaleanchor: x.scaleanchor, y_scaleanchor: y.scaleanchor, y_type: y.type,
  };
}"""


@dataclass(frozen=True)
class Drawn:
    """A chart as it stands on the page."""

    values: dict[str, Any]

    def __getitem__(self, name: str) -> Any:
        return self.values[name]

    def traces(self, *, role: str | None = None, label: str | None = None) -> list[dict[str, Any]]:
        """The traces of a role and a label."""
        return [
            t
            for t in self.values["traces"]
            if (role is None or t["role"] == role) and (label is None or t["label"] == label)
        ]

    @property
    def scales(self) -> tuple[float, float]:
        """Pixels for one unit of x and of y; equal in a plan."""
        x, y = self["x_range"], self["y_range"]
        return self["x_length"] / (x[1] - x[0]), self["y_length"] / (y[1] - y[0])


def panel_of(page: Page, heading: str) -> Locator:
    """The panel with this heading."""
    return page.locator("chart-panel").filter(has=page.get_by_role("heading", name=heading))


def drawn(page: Page, heading: str) -> Drawn:
    """Wait until a chart is drawn and read it."""
    panel = panel_of(page, heading)
    deadline = time.monotonic() + 45
    while True:
        try:
            panel.scroll_into_view_if_needed()
            break
        except Error as error:
            # When a run ends the page puts new panels in the place of those of its parts.
            if "not attached" not in str(error) or time.monotonic() > deadline:
                raise
    page.locator("chart-panel[data-drawn]").filter(has=page.get_by_role("heading", name=heading)).wait_for()
    while (values := panel.evaluate(_READ)) is None:
        assert time.monotonic() < deadline, f"{heading} is not drawn"
        page.wait_for_timeout(50)
    return Drawn(values)
