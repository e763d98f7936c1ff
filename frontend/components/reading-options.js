// @ts-check
// Options of reading beside columns: what a format, or a kind of measurement, lets the user choose.

import { h, put, uniqueId } from "../js/dom.js";
import { t, told } from "../js/i18n.js";
import { parseNumber } from "../js/numbers.js";

/** @import { ReadOption, ReadOptions } from "../types.d.ts" */

export class ReadingOptions {
  /**
   * @param {ReadOption[]} offered
   * @param {ReadOptions} options where the choice begins
   * @param {() => void} onchanged
   */
  constructor(offered, options, onchanged) {
    this.offered = offered;
    /** @type {Record<string, string>} typed or chosen text; empty = left to the reader */
    this.texts = {};
    for (const { name } of offered) {
      const value = options[name];
      this.texts[name] = value === undefined || value === null ? "" : String(value);
    }
    this.onchanged = onchanged;
    this.root = h("div", { class: "fields" });
    put(this.root, offered.map((one) => this.field(one)));
  }

  /** What was chosen; null takes an earlier choice away. @returns {ReadOptions} */
  options() {
    return Object.fromEntries(this.offered.map(({ name, is_number }) => {
      const text = (this.texts[name] ?? "").trim();
      return [name, text === "" ? null : is_number ? parseNumber(text) ?? text : text];
    }));
  }

  /** Names of what was chosen, for people. */
  chosen() {
    return this.offered.filter(({ name }) => (this.texts[name] ?? "").trim()).map(({ name }) => told(`reading.${name}`, name));
  }

  /** @param {ReadOption} one */
  field(one) {
    const id = uniqueId("reading");
    const input = one.values.length
      ? h("select", { id, value: this.texts[one.name], "aria-describedby": `${id}-hint` },
        h("option", { value: "" }, t("reading.left")), one.values.map((value) => h("option", { value }, told(`reading.${one.name}.${value}`, value))))
      : h("input", { id, type: "text", inputmode: one.is_number ? "decimal" : "text", value: this.texts[one.name], placeholder: t("reading.left"), "aria-describedby": `${id}-hint` });
    input.addEventListener(one.values.length ? "change" : "input", () => {
      this.texts[one.name] = input.value;
      this.onchanged();
    });
    return h("div", { class: "field" }, h("div", { class: "name" }, h("label", { for: id }, told(`reading.${one.name}`, one.name))),
      input, h("span", { class: "hint", id: `${id}-hint` }, told(`reading.${one.name}.hint`, one.description)));
  }
}
