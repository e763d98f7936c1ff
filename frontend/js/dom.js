// @ts-check
// The page is built only through `h` and `svg`: text is always a text node, so data can never become markup.

const SVG = "http://www.w3.org/2000/svg";
const PROPERTIES = new Set(["value", "checked", "selected", "disabled", "indeterminate", "hidden", "open"]);

/** @typedef {Node | string | number | null | undefined | false} Child */
/** @typedef {Record<string, any>} Props */

/**
 * @param {Element} element
 * @param {Props} props
 */
function apply(element, props) {
  for (const [name, value] of Object.entries(props)) {
    if (value === null || value === undefined) continue;
    if (name.startsWith("on") && typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (name === "class") element.setAttribute("class", value);
    else if (name === "data") Object.assign(/** @type {HTMLElement} */ (element).dataset, value);
    else if (PROPERTIES.has(name)) /** @type {any} */ (element)[name] = value;
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false) element.setAttribute(name, String(value));
  }
}

/**
 * @param {Element} element
 * @param {(Child | Child[])[]} children
 */
function fill(element, children) {
  for (const child of children.flat()) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : String(child));
  }
}

/**
 * Make an HTML element.
 * @template {string} T
 * @param {T} tag
 * @param {Props | null} [props] attributes; `on<event>` adds a listener, `data` sets data-*
 * @param {...(Child | Child[])} children
 * @returns {T extends keyof HTMLElementTagNameMap ? HTMLElementTagNameMap[T] : HTMLElement}
 */
export function h(tag, props, ...children) {
  const element = document.createElement(tag);
  // Children first: a select takes its value only when its options are there.
  fill(element, children);
  if (props) apply(element, props);
  return /** @type {any} */ (element);
}

/**
 * Make an SVG element.
 * @param {string} tag
 * @param {Props | null} [props]
 * @param {...Child} children
 * @returns {SVGElement}
 */
export function svg(tag, props, ...children) {
  const element = document.createElementNS(SVG, tag);
  if (props) apply(element, props);
  fill(element, children);
  return element;
}

/**
 * Replace what stands inside an element.
 * @param {Element} element
 * @param {...(Child | Child[])} children
 */
export function put(element, ...children) {
  element.replaceChildren();
  fill(element, children);
}

/**
 * Bring what is chosen in a list that is scrolled by itself into sight, where it is not; the page stays where it is.
 * @param {Element | null | undefined} list
 */
export function showChosen(list) {
  const chosen = list?.querySelector("input:checked")?.closest("label");
  if (!list || !chosen) return;
  const [box, own] = [list.getBoundingClientRect(), chosen.getBoundingClientRect()];
  if (own.top < box.top || own.bottom > box.bottom) list.scrollTop += own.top - box.top - (box.height - own.height) / 2;
}

/**
 * Where the focus goes on when one of several was taken away and the rest drawn anew: to what removes the one that took
 * its place, else the last one; to what adds one where none is left.
 * @param {ParentNode | null | undefined} place
 * @param {string} drops selector of the buttons that remove
 * @param {string} adder selector of the button that adds
 * @param {number} at which was taken away
 */
export function focusNear(place, drops, adder, at) {
  const left = /** @type {HTMLElement[]} */ ([...(place?.querySelectorAll(drops) ?? [])]);
  const next = left[Math.min(at, left.length - 1)] ?? /** @type {HTMLElement | null | undefined} */ (place?.querySelector(adder));
  next?.focus({ preventScroll: true });
}

/**
 * Register a custom element once.
 * @param {string} name
 * @param {CustomElementConstructor} type
 */
export function define(name, type) {
  if (!customElements.get(name)) customElements.define(name, type);
}

let counter = 0;

/**
 * An id that is unique in this page, to tie labels and descriptions to fields.
 * @param {string} prefix
 */
export function uniqueId(prefix) {
  counter += 1;
  return `${prefix}-${counter}`;
}
