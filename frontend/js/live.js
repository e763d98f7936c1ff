// @ts-check
// News of runs and recordings: one event stream per tab, open only while somebody waits for something and the
// tab is visible; where the stream fails, the waiting pages are asked to look every two seconds.

import { apiUrl } from "./api.js";

const KINDS = ["run.changed", "run.progress", "recording.changed"];
const LOOK_EVERY_MS = 2000;
// A stream that is silent this long has a dead connection behind it (the server pings every 15 s, but pings
// are invisible to EventSource), so a slow look goes on beside it.
const SLOW_LOOK_MS = 10000;

/** @type {Set<() => void>} */
const waiting = new Set();
/** @type {EventSource | null} */
let stream = null;
let timer = 0;
let lastLook = 0;

/**
 * Call `look` whenever something changed, until the returned function is called.
 * @param {() => void} look must be cheap and safe to call often
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

function tell() {
  lastLook = Date.now();
  for (const look of waiting) look();
}

/** Open or close the stream and the timer according to who waits. */
function adjust() {
  const wanted = waiting.size > 0 && document.visibilityState === "visible";
  if (wanted && !stream) {
    stream = new EventSource(apiUrl("events"));
    for (const kind of KINDS) stream.addEventListener(kind, tell);
    timer = window.setInterval(() => {
      const alive = stream?.readyState === EventSource.OPEN;
      if (stream?.readyState === EventSource.CLOSED) reopen();
      if (!alive || Date.now() - lastLook >= SLOW_LOOK_MS) tell();
    }, LOOK_EVERY_MS);
  } else if (!wanted && stream) {
    stream.close();
    stream = null;
    window.clearInterval(timer);
  }
}

function reopen() {
  stream?.close();
  stream = new EventSource(apiUrl("events"));
  for (const kind of KINDS) stream.addEventListener(kind, tell);
}

document.addEventListener("visibilitychange", () => {
  adjust();
  if (document.visibilityState === "visible") tell();
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
