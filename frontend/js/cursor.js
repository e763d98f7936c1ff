// @ts-check
// One instant, shared by all charts and tables of a page: the mark (row of the recording) that is looked at.

/** @typedef {{row: number | null, label: string | null, locked: boolean}} Cursor */

export class CursorBus extends EventTarget {
  constructor() {
    super();
    /** @type {Cursor} */
    this.now = { row: null, label: null, locked: false };
  }

  /**
   * Look at a mark; a locked cursor only moves by another lock.
   * @param {number | null} row
   * @param {{label?: string | null, lock?: boolean}} [how]
   */
  look(row, { label = null, lock = false } = {}) {
    if (this.now.locked && !lock) return;
    if (row === this.now.row && label === this.now.label && lock === this.now.locked) return;
    this.now = { row, label, locked: lock && row !== null };
    this.dispatchEvent(new Event("change"));
  }

  /** Give the cursor free. */
  release() {
    this.now = { row: null, label: null, locked: false };
    this.dispatchEvent(new Event("change"));
  }
}
