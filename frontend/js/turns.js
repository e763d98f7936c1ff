// @ts-check
// Heavy work one piece after another, with a pause in between in which the page answers.

/** @type {Promise<unknown>} */
let last = Promise.resolve();

/**
 * Do this after everything that was asked for before, in a task of its own.
 * @template T
 * @param {() => T | Promise<T>} act
 * @returns {Promise<T>}
 */
export function inTurn(act) {
  const turn = last.then(() => new Promise((resolve) => { setTimeout(resolve); })).then(act);
  // What fails is its caller's; the next one has its turn all the same.
  last = turn.catch(() => {});
  return turn;
}
