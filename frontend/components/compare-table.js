// @ts-check
// A table with a column for each entry of the compared runs, under the names of the runs.

import { h } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { swatch } from "../js/palette.js";
import { routeTo } from "../js/router.js";
import { emptyState } from "./states.js";

/** @import { Child } from "../js/dom.js" */
/** @import { Comparison } from "../types.d.ts" */

/**
 * @typedef {object} Line
 * @property {Child | Child[]} head
 * @property {string} name
 * @property {(Child | Child[])[]} cells one for each entry
 * @property {boolean} differs
 */

/**
 * @param {Comparison} comparison
 * @param {string} caption
 * @param {Line[]} lines
 * @param {boolean} onlyDifferences leave out lines whose values are all the same
 */
export function compareTable(comparison, caption, lines, onlyDifferences) {
  const shown = onlyDifferences ? lines.filter((line) => line.differs) : lines;
  const same = lines.length - shown.length;
  const foot = same ? h("p", { class: "table-foot" }, t("compare.same_left_out", { n: same })) : null;
  if (!shown.length) return h("div", null, emptyState(t(lines.length ? "compare.no_difference" : "compare.nothing")), foot);
  return h("div", null,
    h("div", { class: "table-wrap", tabindex: 0, role: "region", "aria-label": caption },
      h("table", { class: "compare", data: { table: caption } },
        h("caption", { class: "sr-only" }, caption),
        h("thead", null,
          h("tr", null, h("td"), comparison.runs.map((run) => {
            const span = comparison.entries.filter((entry) => entry.run_id === run.id).length;
            return h("th", { scope: "colgroup", colspan: span, class: "number" }, h("a", { href: routeTo(["runs", run.id]) }, run.title));
          })),
          h("tr", null, h("td"), comparison.entries.map((entry) => h("th", { scope: "col", class: "number" }, swatch(entry.index), " ", entry.entry)))),
        h("tbody", null, shown.map((line) => h("tr", { data: { line: line.name, differs: String(line.differs) } },
          h("th", { scope: "row", title: line.name }, ...[line.head].flat()),
          line.cells.map((cell) => h("td", { class: "number" }, ...[cell].flat()))))))),
    foot);
}
