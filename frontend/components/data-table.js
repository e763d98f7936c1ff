// @ts-check
// A table of rows with typed columns: sorting, pages, and rows that can be chosen.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { go } from "../js/router.js";

/** @import { Child } from "../js/dom.js" */

const FOCUSED = "a, button, input";

/**
 * @template R
 * @typedef {object} Column
 * @property {string} title
 * @property {(row: R) => Child | Child[]} cell
 * @property {(row: R) => string | number | null} [sort] what to sort by; a column without it is not sorted
 * @property {boolean} [number]
 * @property {boolean} [head] the cell names its row
 * @property {boolean} [quiet] its title is only read aloud
 * @property {boolean} [wide] takes the whole width on a phone
 * @property {boolean} [named] its values say nothing without the title; those of numbers never do
 */

export class DataTable extends HTMLElement {
  /** @type {Column<any>[]} */
  columns = [];
  /** @type {any[]} */
  rows = [];
  caption = "";
  fold = false;
  /** Scrolls inside itself, so that what stands above stays in view. */
  tall = false;
  /** @type {((row: any) => void) | null} */
  onpick = null;
  /** @type {((row: any) => string) | null} address that a row opens */
  link = null;
  /** @type {((row: any) => boolean) | null} */
  isCurrent = null;
  pageRows = 50;
  page = 0;
  /** @type {{column: number, down: boolean} | null} */
  order = null;

  connectedCallback() {
    this.draw();
  }

  /** @param {any[]} rows */
  setRows(rows) {
    this.rows = rows;
    this.page = Math.min(this.page, Math.max(0, Math.ceil(rows.length / this.pageRows) - 1));
    this.draw();
  }

  /** What has the focus keeps it when the table is drawn anew: a heading, the table, a row that opens something, a page. */
  heldFocus() {
    const active = document.activeElement;
    if (!active || !this.contains(active)) return () => {};
    const row = /** @type {HTMLElement | null} */ (active.closest("tr[data-opens]"));
    const part = row ? `tr[data-opens="${CSS.escape(row.dataset.opens ?? "")}"]` : ["thead", ".table-foot"].find((one) => active.closest(one));
    const among = (/** @type {ParentNode | null} */ place) => [...(place?.querySelectorAll(FOCUSED) ?? [])];
    const at = part ? among(this.querySelector(part)).indexOf(active) : -1;
    if (!part) return () => { if (active.matches(".table-wrap")) this.focusOn(this.querySelector(".table-wrap")); };
    return () => this.focusOn(among(this.querySelector(part))[at]);
  }

  /** @param {Element | null | undefined} element */
  focusOn(element) {
    /** @type {HTMLElement | null | undefined} */ (element)?.focus({ preventScroll: true });
  }

  ordered() {
    const by = this.order && this.columns[this.order.column]?.sort;
    if (!by || !this.order) return this.rows;
    const sign = this.order.down ? -1 : 1;
    return [...this.rows].sort((a, b) => {
      const [left, right] = [by(a), by(b)];
      if (left === null || right === null) return left === right ? 0 : left === null ? 1 : -1;
      return sign * (typeof left === "number" && typeof right === "number" ? left - right : String(left).localeCompare(String(right)));
    });
  }

  draw() {
    if (!this.isConnected) return;
    const giveBack = this.heldFocus();
    const rows = this.ordered();
    const pages = Math.max(1, Math.ceil(rows.length / this.pageRows));
    const shown = rows.slice(this.page * this.pageRows, (this.page + 1) * this.pageRows);
    put(this,
      h("div", { class: this.tall ? "table-wrap tall" : "table-wrap", tabindex: 0, role: "region", "aria-label": this.caption },
        h("table", { class: this.fold ? "fold" : null },
          h("caption", { class: "sr-only" }, this.caption),
          h("thead", null, h("tr", null, this.columns.map((column, i) => this.heading(column, i)))),
          h("tbody", null, shown.map((row) => this.row(row))))),
      pages > 1 ? h("div", { class: "table-foot" },
        h("button", { class: "plain", type: "button", disabled: this.page === 0, onclick: () => this.turn(-1) }, t("table.previous")),
        h("span", null, t("table.page", { from: formatCount(this.page * this.pageRows + 1), to: formatCount(this.page * this.pageRows + shown.length), of: formatCount(rows.length) })),
        h("button", { class: "plain", type: "button", disabled: this.page >= pages - 1, onclick: () => this.turn(1) }, t("table.next"))) : null);
    giveBack();
  }

  /**
   * @param {Column<any>} column
   * @param {number} i
   */
  heading(column, i) {
    const now = this.order?.column === i ? this.order : null;
    const sort = now ? (now.down ? "descending" : "ascending") : null;
    return h("th", { scope: "col", class: column.number ? "number" : null, "aria-sort": sort },
      column.sort && this.rows.length > 1
        ? h("button", { type: "button", onclick: () => this.orderBy(i) }, column.title, sort ? (now?.down ? " ↓" : " ↑") : "")
        : column.quiet ? h("span", { class: "sr-only" }, column.title) : column.title);
  }

  /** @param {any} row */
  row(row) {
    const current = this.isCurrent?.(row) ?? false;
    const line = h("tr", { class: [this.link ? "link" : this.onpick ? "pick" : "", current ? "current" : ""].join(" ").trim() || null },
      this.columns.map((column) => {
        const classes = [column.number ? "number" : "", column.wide ? "wide" : ""].join(" ").trim();
        // A row that has become a card has no heading over its numbers.
        const title = this.fold && (column.number || column.named) ? column.title : null;
        return h(column.head ? "th" : "td", { class: classes || null, scope: column.head ? "row" : null, data: title ? { title } : {} }, ...[column.cell(row)].flat());
      }));
    if (this.link) {
      const href = this.link(row);
      line.dataset.opens = href;
      line.addEventListener("click", (event) => {
        if (/** @type {Element} */ (event.target).closest("a, button, input") || String(getSelection())) return;
        go(href);
      });
    } else if (this.onpick) {
      line.tabIndex = 0;
      line.addEventListener("click", () => this.onpick?.(row));
      line.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        this.onpick?.(row);
      });
    }
    return line;
  }

  /** @param {number} column */
  orderBy(column) {
    this.order = this.order?.column === column ? (this.order.down ? null : { column, down: true }) : { column, down: false };
    this.page = 0;
    this.draw();
  }

  /** @param {number} step */
  turn(step) {
    this.page += step;
    this.draw();
  }

  /** Turn to the page that holds the first row for which `test` is true. @param {(row: any) => boolean} test */
  turnTo(test) {
    const at = this.ordered().findIndex(test);
    if (at >= 0) this.page = Math.floor(at / this.pageRows);
    this.draw();
    return at >= 0;
  }
}

define("data-table", DataTable);

/**
 * @template R
 * @param {{caption: string, columns: Column<R>[], rows: R[], fold?: boolean, link?: (row: R) => string,
 *   onpick?: (row: R) => void, isCurrent?: (row: R) => boolean, pageRows?: number}} options
 * @returns {DataTable}
 */
export function dataTable(options) {
  const table = /** @type {DataTable} */ (document.createElement("data-table"));
  return Object.assign(table, options);
}
