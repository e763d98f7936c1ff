// @ts-check
// Commands that do again, from a terminal or a script, what the page shows.

/** @import { RunEntry, TrialsRequest } from "../types.d.ts" */

/**
 * @typedef {object} Request
 * @property {string} [recording_id]
 * @property {string[]} [recording_ids]
 * @property {string} [study]
 * @property {TrialsRequest["scenario"]} [scenario]
 * @property {number} [trials]
 * @property {TrialsRequest["sweep"]} [sweep]
 * @property {RunEntry[]} [algorithms]
 * @property {string} [label]
 * @property {string[]} [tags]
 * @property {number} [seed]
 */

/** Quote for a POSIX shell. @param {string} text */
export function shellQuote(text) {
  return `'${text.replaceAll("'", "'\\''")}'`;
}

/**
 * @param {string} base address of the server, ending in a slash
 * @param {Request} request
 */
export function curlSnippet(base, request) {
  return [
    `curl --fail-with-body -X POST ${shellQuote(`${base}api/v1/runs`)} \\`,
    '  -H "Authorization: Bearer $FILTERROOM_TOKEN" \\',
    '  -H "Content-Type: application/json" \\',
    `  -d ${shellQuote(JSON.stringify(request))}`,
  ].join("\n");
}

/**
 * @param {string} base
 * @param {Request} request
 */
export function pythonSnippet(base, request) {
  return `import os, time
import httpx2

client = httpx2.Client(
    base_url=${python(`${base}api/v1/`)},
    headers={"Authorization": f"Bearer {os.environ['FILTERROOM_TOKEN']}"},
)
answer = client.post("runs", json=${python(request)})
answer.raise_for_status()
run = answer.json()
while run["state"] in ("queued", "running"):
    time.sleep(1)
    run = client.get(f"runs/{run['id']}").json()
print(run["state"], run["summary"])
`;
}

/**
 * A value as Python writes it.
 * @param {unknown} value
 * @returns {string}
 */
function python(value) {
  if (value === null || value === undefined) return "None";
  if (value === true) return "True";
  if (value === false) return "False";
  if (Array.isArray(value)) return `[${value.map(python).join(", ")}]`;
  if (typeof value === "object") {
    const pairs = Object.entries(value).filter((pair) => pair[1] !== undefined);
    return `{${pairs.map(([key, one]) => `${JSON.stringify(key)}: ${python(one)}`).join(", ")}}`;
  }
  return JSON.stringify(value);
}
