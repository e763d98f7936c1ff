// @ts-check
// Which column of a foreign CSV means what, in which unit, and which rows are read: a dialog over a look at the file.
// What it starts with is a suggestion from the names of the columns; it takes effect only when the user takes it.

import { h, put } from "../js/dom.js";
import { said, t, told } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { Meanings } from "../js/meanings.js";
import { ReadingOptions } from "./reading-options.js";
import { failed, loading } from "./states.js";

/** @import { Preview, ReadOptions } from "../types.d.ts" */
/** @import { Meaning } from "../js/meanings.js" */

/** @typedef {(options: ReadOptions) => Promise<Preview>} Look */

const FIRST_VALUES = 3;
/** Files up to this size are read on trial after every change, larger ones on request. */
const EAGER_BYTES = 4 * 2 ** 20;

/**
 * Ask what the columns mean.
 * @param {{look: Look, options: ReadOptions, bytes: number}} source
 * @returns {Promise<ReadOptions | null>} kind, mapping and row filter, or null when the user went away
 */
export function mapColumns(source) {
  return new Promise((resolve) => {
    const dialog = h("dialog", { class: "mapping", "aria-labelledby": "mapping-title" });
    const form = new MappingForm(dialog, source);
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(dialog.returnValue === "take" ? form.options() : null);
    });
    document.body.append(dialog);
    dialog.showModal();
    form.open();
  });
}

class MappingForm {
  /**
   * @param {HTMLDialogElement} dialog
   * @param {{look: Look, options: ReadOptions, bytes: number}} source
   */
  constructor(dialog, source) {
    this.dialog = dialog;
    this.source = source;
    this.meanings = new Meanings();
    this.result = h("div", { class: "stack tight", "aria-live": "polite" });
    this.take = h("button", { type: "button", class: "primary", onclick: () => dialog.close("take") }, t("mapping.take"));
    this.close = h("button", { type: "button", onclick: () => dialog.close() }, t("action.give_up"));
    this.asked = 0;
  }

  async open() {
    const title = h("h2", { id: "mapping-title" }, t("mapping.title"));
    put(this.dialog, title, loading(), h("div", { class: "row" }, this.close));
    try {
      this.preview = await this.source.look(this.source.options);
    } catch (error) {
      put(this.dialog, title, failed(error), h("div", { class: "row" }, this.close));
      return;
    }
    const { columns, options } = this.preview;
    if (!columns.length && !options.length) {
      put(this.dialog, title, h("p", { class: "muted" }, t("mapping.no_columns")), h("div", { class: "row" }, this.close));
      return;
    }
    this.choices = new ReadingOptions(options, this.source.options, () => this.changed());
    const buttons = h("div", { class: "row" }, this.take, h("button", { type: "button", onclick: () => this.check() }, t("mapping.check")), this.close);
    if (!columns.length) {
      title.textContent = t("reading.title");
      this.take.textContent = t("reading.take");
      put(this.dialog, title, h("p", { class: "muted" }, t("reading.hint")), this.choices.root, this.result, buttons);
      this.check();
      return;
    }
    this.meanings = Meanings.of(this.preview, this.source.options);
    this.columns = h("div", { class: "table-wrap tall", tabindex: 0, role: "region", "aria-label": t("mapping.columns") });
    this.filters = h("div", { class: "stack tight" });
    put(this.dialog, title,
      h("p", { class: "muted" }, t("mapping.hint")),
      this.kindField(), this.columns, this.filters, options.length ? this.choices.root : null, this.firstRows(), this.result,
      buttons);
    this.drawColumns();
    this.drawFilters();
    this.check();
  }

  /** What was chosen, for the options of an upload. */
  options() {
    const choices = this.choices?.options() ?? {};
    return this.preview?.columns.length ? { ...this.meanings.options(), ...choices } : choices;
  }

  kindField() {
    const { native_columns: kinds } = /** @type {Preview} */ (this.preview);
    const select = h("select", {
      id: "mapping-kind", value: this.meanings.kind, onchange: () => {
        this.meanings.setKind(select.value);
        this.drawColumns();
        this.changed();
      },
    }, Object.keys(kinds).map((kind) => h("option", { value: kind }, told(`kind.${kind}`, kind))));
    return h("div", { class: "field" }, h("label", { for: "mapping-kind" }, t("mapping.kind")), select);
  }

  drawColumns() {
    put(/** @type {HTMLElement} */ (this.columns), h("table", null,
      h("thead", null, h("tr", null, [t("mapping.column"), t("mapping.values"), t("mapping.means"), t("mapping.unit")].map((name) => h("th", { scope: "col" }, name)))),
      h("tbody", null, this.meanings.columns.map((one, i) => this.columnRow(one, i)))));
  }

  /**
   * @param {Meaning} one
   * @param {number} i its place in the file
   */
  columnRow(one, i) {
    const values = (this.preview?.rows ?? []).slice(0, FIRST_VALUES).map((row) => row[i] ?? "").join("; ");
    const names = this.meanings.offered(one);
    const means = h("select", {
      value: one.means, "aria-label": t("mapping.means_of", { column: one.column }), onchange: () => {
        this.meanings.setMeaning(one, means.value);
        redraw();
        this.changed();
      },
    }, one.native ? null : h("option", { value: "" }, t("mapping.unused")), names.map((name) => h("option", { value: name }, name)));
    const extra = h("div", { class: "stack tight" });
    const unit = h("td");
    const redraw = () => {
      put(extra, this.stationField(one), this.minusField(one));
      put(unit, this.unitField(one));
    };
    redraw();
    return h("tr", null, h("th", { scope: "row", class: "break" }, one.column), h("td", { class: "small break" }, values), h("td", null, means, extra), unit);
  }

  /** @param {Meaning} one */
  stationField(one) {
    if (!Meanings.isReception(one)) return null;
    return h("input", {
      type: "text", value: one.station, maxlength: 80, placeholder: t("mapping.station"), "aria-label": t("mapping.station_of", { column: one.column }),
      oninput: (/** @type {Event} */ event) => {
        one.station = /** @type {HTMLInputElement} */ (event.target).value.trim();
        this.changed();
      },
    });
  }

  /** The radar's own position is taken off plots in a fixed frame. @param {Meaning} one */
  minusField(one) {
    if (one.means !== "east_m" && one.means !== "north_m") return null;
    const others = this.meanings.columns.filter((other) => other !== one);
    const select = h("select", {
      value: one.minus, "aria-label": t("mapping.minus_of", { column: one.column }), onchange: () => {
        one.minus = select.value;
        this.changed();
      },
    }, h("option", { value: "" }, t("mapping.minus_nothing")), others.map((other) => h("option", { value: other.column }, t("mapping.minus", { column: other.column }))));
    return select;
  }

  /** @param {Meaning} one */
  unitField(one) {
    const units = this.meanings.unitsOf(one);
    if (!units.length) return null;
    const select = h("select", {
      value: one.unit || units[0], "aria-label": t("mapping.unit_of", { column: one.column }), onchange: () => {
        one.unit = select.value;
        this.changed();
      },
    }, units.map((name) => h("option", { value: name }, name)));
    return select;
  }

  drawFilters() {
    const { filters, columns } = this.meanings;
    put(/** @type {HTMLElement} */ (this.filters),
      filters.map((filter, i) => {
        const column = h("select", { value: filter.column, "aria-label": t("mapping.filter_column"), onchange: () => { filter.column = column.value; this.changed(); } },
          columns.map((one) => h("option", { value: one.column }, one.column)));
        const value = h("input", { type: "text", value: filter.value, "aria-label": t("mapping.filter_value"), oninput: () => { filter.value = value.value; this.changed(); } });
        return h("div", { class: "row" }, h("span", null, t("mapping.only_rows")), h("span", null, column), "=", h("span", null, value),
          h("button", { type: "button", class: "plain", onclick: () => { filters.splice(i, 1); this.drawFilters(); this.changed(); } }, t("mapping.filter_remove")));
      }),
      h("div", null, h("button", {
        type: "button", class: "plain", onclick: () => {
          filters.push({ column: columns[0]?.column ?? "", value: "" });
          this.drawFilters();
        },
      }, t("mapping.filter_add"))));
  }

  firstRows() {
    const { columns, rows } = /** @type {Preview} */ (this.preview);
    return h("details", null, h("summary", null, t("mapping.first_rows", { n: rows.length })),
      h("div", { class: "table-wrap tall", tabindex: 0, role: "region", "aria-label": t("mapping.first_rows", { n: rows.length }) },
        h("table", null, h("thead", null, h("tr", null, columns.map((name) => h("th", { scope: "col" }, name)))),
          h("tbody", null, rows.map((row) => h("tr", null, row.map((cell) => h("td", null, cell))))))));
  }

  changed() {
    clearTimeout(this.timer);
    this.asked += 1;
    if (this.source.bytes <= EAGER_BYTES) this.timer = setTimeout(() => this.check(), 400);
    else put(this.result, h("p", { class: "muted" }, t("mapping.not_checked")));
  }

  /** Read on trial with what is chosen; an answer to an earlier choice is not shown. */
  async check() {
    this.asked += 1;
    const mine = this.asked;
    const twice = this.meanings.repeated();
    this.take.disabled = twice.length > 0;
    if (twice.length) {
      put(this.result, h("p", { class: "bad" }, t("mapping.twice", { names: twice.join(", ") })));
      return;
    }
    try {
      const answer = await this.source.look({ ...this.source.options, ...this.options() });
      if (mine === this.asked) put(this.result, ...outcome(answer));
    } catch (error) {
      if (mine === this.asked) put(this.result, failed(error));
    }
  }
}

/** What reading would give. @param {Preview} preview */
function outcome(preview) {
  if (preview.error) return [failed({ ...preview.error, title: t("mapping.gives_nothing") })];
  const { trial } = preview;
  if (!trial) return [];
  const { read, accepted, rejected } = trial.rows;
  return [
    h("p", null, h("strong", { class: rejected ? "warn" : "good" }, t("mapping.counts", { n: read, read: formatCount(read), accepted: formatCount(accepted), rejected: formatCount(rejected) }))),
    trial.rejections.length ? h("ul", { class: "small" }, trial.rejections.slice(0, 3).map((one) => h("li", { class: "break" }, said(one.detail)))) : null,
    trial.warnings.length ? h("ul", { class: "small muted" }, trial.warnings.map((one) => h("li", { class: "break" }, said(one.detail)))) : null,
  ].filter((node) => node !== null);
}
