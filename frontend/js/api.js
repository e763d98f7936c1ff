// @ts-check
// The only way to the server: JSON in and out, errors as `Problem`, addresses relative to the page so that a
// forwarded port or a path prefix changes nothing.

/** @import { ProblemBody, FieldError, Page } from "../types.d.ts" */

/** @typedef {Record<string, string | number | boolean | string[] | null | undefined>} Query */

/** What the server answered when it could not do what was asked, or that it did not answer. */
export class Problem extends Error {
  /**
   * @param {number} status 0 when there was no answer
   * @param {ProblemBody} body
   */
  constructor(status, body) {
    super(body.detail || body.title || `HTTP ${status}`);
    this.status = status;
    this.title = body.title ?? "";
    this.detail = body.detail ?? "";
    this.remedy = body.remedy ?? "";
    this.code = body.code ?? "";
    /** @type {FieldError[]} */
    this.errors = body.errors ?? [];
  }
}

/** Tells `lost`, `found` and `unauthorised` to whoever shows it. */
export const connection = new EventTarget();
let reachable = true;

/** @param {boolean} now */
function setReachable(now) {
  if (now === reachable) return;
  reachable = now;
  connection.dispatchEvent(new Event(now ? "found" : "lost"));
}

/** Whether the last request reached the server. */
export function isReachable() {
  return reachable;
}

/**
 * The address of an API resource, relative to the page.
 * @param {string} path without the prefix: `runs/ID`
 * @param {Query} [query] empty values are left out, arrays repeat their name
 */
export function apiUrl(path, query = {}) {
  const url = new URL(`api/v1/${path}`, document.baseURI);
  for (const [name, value] of Object.entries(query)) {
    for (const one of Array.isArray(value) ? value : [value]) {
      if (one !== null && one !== undefined && one !== "") url.searchParams.append(name, String(one));
    }
  }
  return url.href;
}

/**
 * @param {string} method
 * @param {string} url
 * @param {{body?: unknown, signal?: AbortSignal}} [options]
 * @returns {Promise<Response>}
 */
async function send(method, url, options = {}) {
  /** @type {RequestInit} */
  const request = { method, headers: { Accept: "application/json" }, signal: options.signal };
  if (options.body instanceof FormData) request.body = options.body;
  else if (options.body !== undefined) {
    request.body = JSON.stringify(options.body);
    request.headers = { Accept: "application/json", "Content-Type": "application/json" };
  }
  let response;
  try {
    response = await fetch(url, request);
  } catch (error) {
    if (options.signal?.aborted) throw error;
    setReachable(false);
    throw new Problem(0, { code: "server_unreachable", title: "The server does not answer" });
  }
  setReachable(true);
  if (response.ok) return response;
  const body = await response.json().catch(() => ({ title: response.statusText, code: `http_${response.status}` }));
  if (response.status === 401) connection.dispatchEvent(new Event("unauthorised"));
  throw new Problem(response.status, body);
}

/**
 * @template T
 * @param {string} path
 * @param {{query?: Query, signal?: AbortSignal}} [options]
 * @returns {Promise<T>}
 */
export async function get(path, options = {}) {
  const response = await send("GET", apiUrl(path, options.query), options);
  return response.json();
}

/**
 * @param {string} path
 * @param {{query?: Query, signal?: AbortSignal}} [options]
 */
export async function getText(path, options = {}) {
  const response = await send("GET", apiUrl(path, options.query), options);
  return response.text();
}

/**
 * @template T
 * @param {string} path
 * @param {unknown} [body] JSON, or FormData for an upload
 * @returns {Promise<T>}
 */
export async function post(path, body) {
  const response = await send("POST", apiUrl(path), { body });
  return response.json();
}

/**
 * Change some fields of a resource.
 * @template T
 * @param {string} path
 * @param {unknown} body
 * @returns {Promise<T>}
 */
export async function patch(path, body) {
  const response = await send("PATCH", apiUrl(path), { body });
  return response.json();
}

/**
 * @param {string} path
 * @param {Record<string, string | undefined>} [query]
 */
export async function remove(path, query = {}) {
  await send("DELETE", apiUrl(path, query));
}

/**
 * All pages of a list; a list that never ends is cut at `most` entries.
 * @template T
 * @param {string} path
 * @param {{most?: number, signal?: AbortSignal}} [options]
 * @returns {Promise<T[]>}
 */
export async function listAll(path, options = {}) {
  /** @type {T[]} */
  const items = [];
  /** @type {string | null | undefined} */
  let cursor;
  do {
    /** @type {Page<T>} */
    const page = await get(path, { query: { cursor }, signal: options.signal });
    items.push(...page.items);
    cursor = page.next_cursor;
  } while (cursor && items.length < (options.most ?? 1000));
  return items;
}
