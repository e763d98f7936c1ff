// @ts-check
// News of runs and recordings: one event stream per tab, open only while somebody waits for something and the
// tab is visible, because a browser opens few connections to one server; where the stream fails, the waiting pages
// are asked to look every two seconds.

import { apiUrl } from "./api.js";

const KINDS = ["run.changed", "run.progress", "recording.changed"];
const LOOK_EVERY_MS = 2000;
// A stream that is silent this long has a dead connection behind it (the server pings every 15 s, but pings
// are invisible to EventSource), so a slow look goes on beside it.
const SLOW_LOOK_MS = 10000;

/**
 * What changed; null = anything may have: nobody was listening for a while.
 * @typedef {{kind: string, id: string, state?: string} | null} News
 */

/** @type {Set<(news: News) => void>} */
const waiting = new Set();
/** @type {EventSource | null} */
let stream = null;
let timer = 0;
let lastLook = 0;

/**
 * Call `look` whenever something changed, until the returned function is called.
 * @param {(news: News) => void} look must be cheap and safe to call often
 * @returns {() => void}
 */
export function watch(look) {
  waiting.add(look);
  adjust();
  return () => {
    waiting.delete(look);
    adjust();
  };
}

/** @param {News} news */
function tell(news) {
  if (news === null) lastLook = Date.now();
  for (const look of waiting) look(news);
}

function open() {
  stream = new EventSource(apiUrl("events"));
  // What happened before it opened, or while it was away, was not told.
  stream.addEventListener("open", () => tell(null));
  for (const kind of KINDS) {
    stream.addEventListener(kind, (event) => {
      const { id, run_id: run, state } = JSON.parse(/** @type {MessageEvent} */ (event).data);
      tell({ kind, id: id ?? run ?? "", state });
    });
  }
}

/** Open or close the stream and the timer according to who waits. */
function adjust() {
  const wanted = waiting.size > 0 && document.visibilityState === "visible";
  if (wanted && !stream) {
    open();
    timer = window.setInterval(() => {
      const alive = stream?.readyState === EventSource.OPEN;
      if (stream?.readyState === EventSource.CLOSED) open();
      if (!alive || Date.now() - lastLook >= SLOW_LOOK_MS) tell(null);
    }, LOOK_EVERY_MS);
  } else if (!wanted && stream) {
    stream.close();
    stream = null;
    window.clearInterval(timer);
  }
}

document.addEventListener("visibilitychange", () => {
  adjust();
  if (document.visibilityState === "visible") tell(null);
});
window.addEventListener("pagehide", () => stream?.close());

/**
 * Wrap a slow look so that calls in quick succession become one at a time, at most two per second.
 * @param {() => Promise<void>} look
 */
export function throttled(look) {
  let busy = false;
  let again = false;
  return async () => {
    if (busy) {
      again = true;
      return;
    }
    busy = true;
    try {
      do {
        again = false;
        await look();
        await new Promise((resolve) => setTimeout(resolve, 500));
      } while (again);
    } finally {
      busy = false;
    }
  };
}

/**
 * Call `look` whenever `news` tells of something new, until the box that it fills is taken away.
 * @param {EventTarget} news
 * @param {HTMLElement} box
 * @param {() => void} look
 */
export function follow(news, box, look) {
  const listener = () => {
    if (box.isConnected) look();
    else news.removeEventListener("more", listener);
  };
  news.addEventListener("more", listener);
}
