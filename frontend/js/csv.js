// @ts-check
// Read the CSV that the server sends (RFC 4180) for the tables of the page.

/**
 * @param {string} text
 * @param {number} [most] read at most this many data rows
 * @returns {{columns: string[], rows: string[][], more: boolean}}
 */
export function parseCsv(text, most = Infinity) {
  /** @type {string[][]} */
  const lines = [];
  /** @type {string[]} */
  let line = [];
  let cell = "";
  let quoted = false;
  let more = false;
  for (let i = 0; i < text.length; i += 1) {
    const sign = text[i];
    if (quoted) {
      if (sign !== '"') cell += sign;
      else if (text[i + 1] === '"') {
        cell += '"';
        i += 1;
      } else quoted = false;
    } else if (sign === '"') quoted = true;
    else if (sign === ",") {
      line.push(cell);
      cell = "";
    } else if (sign === "\n") {
      line.push(cell.endsWith("\r") ? cell.slice(0, -1) : cell);
      cell = "";
      lines.push(line);
      line = [];
      if (lines.length > most) {
        more = i + 1 < text.length;
        break;
      }
    } else cell += sign;
  }
  if (cell || line.length) {
    line.push(cell);
    lines.push(line);
  }
  return { columns: (lines[0] ?? []).map((name) => name.replace(/^\ufeff/, "")), rows: lines.slice(1), more };
}
