// @ts-check
// One instant, shared by all charts and tables of a page: its time, and the mark (row of the recording) looked at.

/** @typedef {{time: number | null, row: number | null, label: string | null, locked: boolean}} Cursor */

/** @type {Cursor} */
const NOWHERE = { time: null, row: null, label: null, locked: false };

export class CursorBus extends EventTarget {
  now = NOWHERE;

  /**
   * Look at an instant; a locked cursor only moves by another lock.
   * @param {number | null} time
   * @param {{row?: number | null, label?: string | null, lock?: boolean}} [how]
   */
  look(time, { row = null, label = null, lock = false } = {}) {
    const { now } = this;
    if (now.locked && !lock) return;
    if (time === now.time && row === now.row && label === now.label && lock === now.locked) return;
    this.now = { time, row, label, locked: lock && time !== null };
    this.dispatchEvent(new Event("change"));
  }

  /** Give the cursor free. */
  release() {
    if (this.now === NOWHERE) return;
    this.now = NOWHERE;
    this.dispatchEvent(new Event("change"));
  }
}
