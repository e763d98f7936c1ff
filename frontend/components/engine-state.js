// @ts-check
// The engine in one line: warming up, ready with so many workers, so many runs running and queued.

import { define, put, h } from "../js/dom.js";
import { get, Problem } from "../js/api.js";
import { said, t } from "../js/i18n.js";

/** @import { Meta } from "../types.d.ts" */

// While the workers start, look often enough that the change is seen; afterwards it is only for the curious.
const WARMING_MS = 2000;
const READY_MS = 15000;

export class EngineState extends HTMLElement {
  /** Says in words what hinders the engine, and what to do. @type {HTMLElement | undefined} */
  line = undefined;

  connectedCallback() {
    this.className = "small muted clip";
    this.stop = new AbortController();
    document.addEventListener("visibilitychange", () => this.look(), { signal: this.stop.signal });
    document.addEventListener("filterroom:runs", () => this.look(), { signal: this.stop.signal });
    this.look();
  }

  disconnectedCallback() {
    this.stop?.abort();
    window.clearTimeout(this.timer);
  }

  async look() {
    window.clearTimeout(this.timer);
    if (document.visibilityState === "hidden") return;
    let next = WARMING_MS;
    try {
      /** @type {Meta} */
      const meta = await get("meta", { signal: this.stop?.signal });
      this.show(meta.engine);
      if (meta.engine.state === "ready" && !meta.engine.running && !meta.engine.queued) next = READY_MS;
    } catch (error) {
      put(this); // the frame already says that the server is lost, or asks for the token
      if (error instanceof Problem && error.status === 401) return;
    }
    if (this.isConnected) this.timer = window.setTimeout(() => this.look(), next);
  }

  /** @param {Meta["engine"]} engine */
  show(engine) {
    const words = engine.state === "failed" ? engine.detail : engine.warning;
    if (this.line) {
      if (this.line.textContent !== said(words ?? "")) this.line.textContent = said(words ?? "");
      this.line.hidden = !words;
    }
    if (engine.state === "failed" || engine.state === "stopped") put(this, h("span", { class: "bad", title: said(engine.detail ?? "") || null }, t("engine.failed")));
    else if (engine.state !== "ready") put(this, h("span", { class: "warn", title: said(engine.detail ?? "") || null }, t("engine.warming_up")));
    else if (!engine.workers && engine.detail) put(this, h("span", { class: "warn", title: said(engine.detail) }, t("engine.ready", { n: 0 })));
    else {
      const busy = engine.running || engine.queued ? `, ${t("engine.busy", { running: engine.running, queued: engine.queued })}` : "";
      put(this, `${t("engine.ready", { n: engine.workers })}${busy}`);
    }
  }
}

define("engine-state", EngineState);
