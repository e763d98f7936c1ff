// @ts-check
// Sentences of the server in another language: templates with places `{1}`, `{2}` are recognised in the English text,
// and what stands in the places is carried over, itself translated where it is a sentence.

/** @typedef {{whole: RegExp, start: RegExp, words: string, bare: boolean, chunk: string}} Template */

// A template with fewer letters of its own (`{1}: {2}`) says nothing by itself: something in it must be known.
const FEWEST_LETTERS = 3;
// Message and remedy come as one text; nothing the server says has more parts than this.
const MOST_PARTS = 6;

/** @param {string} text */
const quoted = (text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

/** Make a translator of whole texts. @param {Record<string, string>} sentences */
export function translator(sentences) {
  const letters = (/** @type {string} */ text) => text.replace(/\{\d+\}|[^A-Za-z]/g, "").length;
  /** @type {Template[]} */
  const templates = Object.entries(sentences).sort(([a], [b]) => letters(b) - letters(a)).map(([english, words]) => {
    const chunks = english.split(/\{\d+\}/);
    const source = chunks.map(quoted).join("(.+?)");
    const chunk = chunks.reduce((a, b) => (b.length > a.length ? b : a));
    return { whole: new RegExp(`^${source}$`), start: new RegExp(`^${source} (?=\\S)`), words, bare: letters(english) < FEWEST_LETTERS, chunk };
  });

  /**
   * @param {Template} template
   * @param {RegExpExecArray} found
   * @param {number} parts
   */
  function render({ words, bare }, found, parts) {
    const known = found.slice(1).map((value) => translate(value, parts - 1));
    if (bare && known.every((value) => value === null)) return null;
    return words.replace(/\{(\d+)\}/g, (_, i) => known[i - 1] ?? (found[i] ?? "").replace(/ and (\d+) more$/, " и ещё $1"));
  }

  /**
   * The text in the other language, or null where a part of it is not known.
   * @param {string} text
   * @param {number} [parts]
   * @returns {string | null}
   */
  function translate(text, parts = MOST_PARTS) {
    if (parts === 0) return null;
    const fitting = templates.filter(({ chunk }) => text.includes(chunk));
    for (const template of fitting) {
      const found = template.whole.exec(text);
      const words = found && render(template, found, parts);
      // A place may have taken the end of one sentence and the beginning of the next: then the parts come first.
      if (words && !swallowed(found)) return words;
    }
    for (const template of fitting) {
      const found = template.bare ? null : template.start.exec(text);
      const rest = found && translate(text.slice(found[0].length), parts - 1);
      const words = rest && found && render(template, found, parts);
      if (words) return `${words} ${rest}`;
    }
    return null;
  }

  return translate;
}

/** Whether a place holds the end of one sentence and the beginning of another, outside of quoted names. @param {RegExpExecArray} found */
function swallowed(found) {
  return found.slice(1).some((value) => /[.!?] [A-Z]/.test(value.replace(/'[^']*'|`[^`]*`/g, "")));
}
