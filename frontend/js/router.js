// @ts-check
// Hash routes; everything a page shows is in its address, so it can be shared, reloaded and gone back to.

/** @typedef {{path: string[], query: URLSearchParams}} Route */

/**
 * Split `#/runs/ID?tab=log`.
 * @param {string} hash
 * @returns {Route}
 */
export function parseRoute(hash) {
  const [path = "", query = ""] = hash.replace(/^#\/?/, "").split(/\?(.*)/s);
  const parts = path.split("/").filter(Boolean).map(decode);
  return { path: parts.length ? parts : ["runs"], query: new URLSearchParams(query) };
}

/** @param {string} part */
function decode(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part; // a stray % in a typed address: take it literally
  }
}

/**
 * Make a hash address; empty values are left out, arrays repeat their name.
 * @param {string[]} path
 * @param {Record<string, string | string[] | null | undefined>} [query]
 */
export function routeTo(path, query = {}) {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    for (const one of Array.isArray(value) ? value : [value]) if (one) search.append(name, one);
  }
  const text = search.toString();
  return `#/${path.map(encodeURIComponent).join("/")}${text ? `?${text}` : ""}`;
}

/**
 * The browser itself would tell of a new address only later, and a key pressed meanwhile would act on a page that is
 * about something else than the address says.
 * @param {string} hash
 */
export function go(hash) {
  if (location.hash !== hash) history.pushState(null, "", hash);
  window.dispatchEvent(new HashChangeEvent("hashchange"));
}

/**
 * The address of the page with another query; what is not named stays.
 * @param {Record<string, string | string[] | null | undefined>} query
 */
function withQuery(query) {
  const route = parseRoute(location.hash);
  /** @type {Record<string, string | string[]>} */
  const kept = {};
  for (const name of new Set(route.query.keys())) kept[name] = route.query.getAll(name);
  return routeTo(route.path, { ...kept, ...query });
}

/**
 * Remember a page's state in its address without a new entry in the history.
 * @param {Record<string, string | string[] | null | undefined>} query
 */
export function rememberQuery(query) {
  history.replaceState(history.state, "", withQuery(query));
}

/**
 * Change what a page is about, so that the browser's way back leads to what it was.
 * @param {Record<string, string | string[] | null | undefined>} query
 */
export function changeQuery(query) {
  const address = withQuery(query);
  if (address !== location.hash) go(address);
}
