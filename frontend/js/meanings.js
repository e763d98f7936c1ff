// @ts-check
// What each column of a file means: from a suggestion or from options, and back into options.

/** @import { Preview, ReadOptions, ColumnSource } from "../types.d.ts" */

/**
 * A column of the file. `native`: it is called like a native one, and then it is read as that whatever a mapping says.
 * @typedef {{column: string, native: boolean, means: string, unit: string, station: string, minus: string}} Meaning
 */

const RECEPTION = "toa_<station>_ns";
const RECEPTION_COLUMN = /^toa_(.+)_ns$/s;

export class Meanings {
  kind = "";
  /** @type {Meaning[]} */
  columns = [];
  /** @type {{column: string, value: string}[]} */
  filters = [];
  /** @type {Preview["native_columns"]} */
  natives = {};

  /**
   * Begin with what the options say, else with what is suggested.
   * @param {Preview} preview
   * @param {ReadOptions} options
   */
  static of(preview, options) {
    const out = new Meanings();
    const told = Object.keys(options.mapping ?? {}).length > 0;
    const mapping = told ? (options.mapping ?? {}) : preview.suggestion.mapping;
    out.natives = preview.native_columns;
    out.kind = options.kind ?? preview.trial?.kind ?? preview.suggestion.kind ?? Object.keys(out.natives)[0] ?? "";
    out.filters = Object.entries(options.where ?? {}).map(([column, value]) => ({ column, value: String(value) }));
    out.columns = preview.columns.filter((name) => name).map((column) => ({ column, native: out.isNative(column), means: "", unit: "", station: "", minus: "" }));
    for (const one of out.columns) if (one.native) out.setMeaning(one, column(one.column));
    for (const [name, given] of Object.entries(mapping)) {
      const source = typeof given === "string" ? { column: given } : given;
      const one = out.columns.find((other) => other.column === source.column);
      if (one) out.apply(one, name, source);
    }
    return out;
  }

  /** @param {Meaning} one */
  static isReception(one) {
    return one.means === RECEPTION;
  }

  /**
   * @param {Meaning} one
   * @param {string} name native
   * @param {ColumnSource} source
   */
  apply(one, name, source) {
    one.means = column(name);
    one.station = RECEPTION_COLUMN.exec(name)?.[1] ?? "";
    one.unit = source.unit ?? "";
    one.minus = source.minus ?? "";
  }

  /** @param {string} name */
  isNative(name) {
    return this.known().some((one) => one.name === name) || (this.kind === "toa_marks" && RECEPTION_COLUMN.test(name));
  }

  known() {
    return this.natives[/** @type {keyof Preview["native_columns"]} */ (this.kind)] ?? [];
  }

  /** @param {string} kind */
  setKind(kind) {
    this.kind = kind;
    for (const one of this.columns) {
      one.native = this.isNative(one.column);
      if (one.native) this.setMeaning(one, column(one.column));
      else if (!this.known().some((native) => native.name === one.means)) this.setMeaning(one, "");
    }
  }

  /**
   * @param {Meaning} one
   * @param {string} means
   */
  setMeaning(one, means) {
    one.means = means;
    one.unit = "";
    one.minus = "";
    if (means === RECEPTION) one.station ||= RECEPTION_COLUMN.exec(one.column)?.[1] ?? one.column;
  }

  /** Native names that a column may mean. @param {Meaning} one */
  offered(one) {
    return one.native ? [one.means] : this.known().map((native) => native.name);
  }

  /** @param {Meaning} one */
  unitsOf(one) {
    return this.known().find((native) => native.name === one.means)?.units ?? [];
  }

  /** The native name with its station. @param {Meaning} one */
  nameOf(one) {
    return one.means === RECEPTION ? `toa_${one.station}_ns` : one.means;
  }

  /** Names that two columns have. */
  repeated() {
    const names = this.columns.filter((one) => one.means).map((one) => this.nameOf(one));
    return [...new Set(names.filter((name, i) => names.indexOf(name) !== i))];
  }

  /** @returns {ReadOptions} */
  options() {
    /** @type {Record<string, ColumnSource>} */
    const mapping = {};
    for (const one of this.columns) {
      const name = this.nameOf(one);
      const unit = one.unit && one.unit !== this.unitsOf(one)[0] ? one.unit : "";
      // A native column in its native unit says all of it by its name.
      if (!one.means || (name === one.column && !unit && !one.minus)) continue;
      mapping[name] = { column: one.column, ...(unit ? { unit } : {}), ...(one.minus ? { minus: one.minus } : {}) };
    }
    return {
      kind: this.kind,
      mapping,
      where: Object.fromEntries(this.filters.filter((filter) => filter.column && filter.value !== "").map((filter) => [filter.column, filter.value])),
    };
  }
}

/** The name under which a native column is offered. @param {string} name */
function column(name) {
  return RECEPTION_COLUMN.test(name) ? RECEPTION : name;
}
