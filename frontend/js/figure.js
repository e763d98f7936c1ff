// @ts-check
// What the page does to the server's figures: colours of the theme, hidden entries, quiet hovers, finding marks.

import { said, t } from "./i18n.js";
import { formatNumber, formatQuantity } from "./numbers.js";
import { withDots } from "./dots.js";

/** @import { Figure, Trace } from "../types.d.ts" */

/** @typedef {{text: string, muted: string, line: string, grid: string, surface: string, measurement: string}} Colours */

/** Roles whose colour belongs to the theme and not to an entry. */
const THEMED = { truth: "text", station: "text", measurement: "measurement", bound: "muted" };

// Letters of ticks, and the room of the axis on the narrowest page.
const LETTER_PX = 6;
const NARROWEST_PX = 280;
const LEGEND_ROW_PX = 19;
// Width of a letter, of its height; of Cyrillic ones, which are wider.
const LETTER_SHARE = 0.64;
// Letters that are still read.
const SMALLEST_TITLE = 9;

/** Few to many: the server's sequence for light surfaces, and what stands for each colour on dark ones. */
const SEQUENCE = {
  "#f0f4f8": "#1b2228", "#c9dcec": "#1d3a52", "#94bfdd": "#25587f", "#5a9bc8": "#3a7fb4", "#2a77ae": "#6fa8d6", "#0b4f82": "#b5d6f2",
};

/**
 * The figure as the page shows it: a changed copy.
 * @param {Figure} figure
 * @param {{colours: Colours, dark: boolean, hidden: Set<string>, font: string, narrow: boolean, width?: number, height?: number, dots?: boolean}} look
 *   `dots`: crowds of markers are left to the canvas
 * @returns {Figure}
 */
export function dressFigure(figure, { colours, dark, hidden, font, narrow, width = 0, height = 0, dots = true }) {
  const named = Boolean(figure.layout.meta?.legend);
  const dressed = figure.data.map((trace) => dressTrace(trace, { colours, dark, hidden, named }));
  const painted = dots ? dressed.map(withDots) : dressed;
  const data = [...painted, ...painted.flatMap((trace, i) => keyOf(trace, /** @type {Trace} */ (dressed[i])))];
  const layout = { ...figure.layout };
  delete layout.title;
  delete layout.width;
  delete layout.height;
  layout.paper_bgcolor = "rgba(0,0,0,0)";
  layout.plot_bgcolor = "rgba(0,0,0,0)";
  layout.font = { ...layout.font, color: colours.text, family: font, size: narrow ? 11 : 12 };
  // The chips are the legend of the entries; what belongs to none has one of its own, and so has a chart that asks for it.
  layout.showlegend = data.some((trace) => trace.showlegend);
  layout.legend = { orientation: "h", x: 0, y: 1, xanchor: "left", yanchor: "bottom", font: { size: 11 }, traceorder: "normal" };
  const legend = layout.showlegend ? legendHeight(data.filter((trace) => trace.showlegend).map((trace) => String(trace.name ?? "")), width) : 0;
  layout.autosize = true;
  layout.uirevision = "kept";
  layout.margin = { l: narrow ? 48 : 58, r: 12, t: 8, b: narrow ? 36 : 40, pad: 0 };
  // Over time the page reads the instant under the pointer itself; only maps need Plotly to find the cell.
  layout.hovermode = isOverTime(figure) && !data.some((trace) => trace.type === "heatmap") ? false : "closest";
  for (const name of Object.keys(layout)) {
    if (!/^[xy]axis\d*$/.test(name)) continue;
    const title = titleInWords(axisTitle(layout[name]));
    const size = narrow ? 11 : 12;
    layout[name] = {
      ...layout[name],
      ...(narrow ? fewerTicks(layout[name]) : {}),
      title: { ...layout[name].title, text: title, font: { size: name.startsWith("y") ? titleSize(title, layout[name].domain, size, height - legend) : size } },
      color: colours.text,
      gridcolor: colours.grid,
      zerolinecolor: colours.line,
      linecolor: colours.line,
      tickcolor: colours.line,
    };
  }
  if (layout.scene) layout.scene = dressScene(layout.scene, colours);
  if (layout.annotations) {
    layout.annotations = layout.annotations.map((/** @type {any} */ note) => ({
      ...note,
      text: annotationInWords(note.text ?? ""),
      font: { ...note.font, color: colours.muted },
      // Names of intervals side by side have room only upright.
      ...(narrow && note.xref === "x" && note.yref === "paper" && note.y === 1 ? { textangle: -90, xanchor: "center", yshift: 0 } : {}),
      ...(note.arrowcolor ? { arrowcolor: colours.muted } : {}),
    }));
  }
  if (layout.shapes) {
    layout.shapes = layout.shapes.map((/** @type {any} */ shape) => ({
      ...shape,
      line: { ...shape.line, color: colours.muted },
    }));
  }
  return { data, layout };
}

/**
 * A crowd is painted apart, so its place in the legend would be empty: a trace without points has its marker there.
 * @param {Trace} painted
 * @param {Trace} dressed the same with its markers
 * @returns {Trace[]}
 */
function keyOf(painted, dressed) {
  if (!painted.meta?.dot || painted.mode !== "none" || !painted.showlegend) return [];
  painted.showlegend = false;
  return [{ type: "scatter", mode: "markers", x: [null], y: [null], name: dressed.name, marker: dressed.marker, legendgroup: dressed.legendgroup, visible: dressed.visible, showlegend: true, hoverinfo: "skip", meta: {} }];
}

/**
 * How high a legend above the plot is, px, as Plotly lays it out: columns as wide as the longest name.
 * @param {string[]} names
 * @param {number} width of the chart
 */
function legendHeight(names, width) {
  const columns = Math.max(1, Math.floor((width - 130) / (45 + LETTER_PX * Math.max(...names.map((name) => name.length)))));
  return LEGEND_ROW_PX * Math.ceil(names.length / columns);
}

/**
 * Size of the letters of an upright title: smaller where it would run into those of the panels above and below, or out
 * of a low chart.
 * @param {string} title
 * @param {[number, number] | undefined} domain of the axis, parts of the plot's height
 * @param {number} size where there is room
 * @param {number} height of the chart without its legend, px; not positive = not known
 */
export function titleSize(title, domain, size, height) {
  if (height <= 0 || !title) return size;
  const share = domain ? domain[1] - domain[0] : 1;
  // Above the plot and below it a title may reach into the margins.
  const room = share * (height - 48) + (share === 1 ? 24 : 0);
  return Math.max(SMALLEST_TITLE, Math.min(size, Math.floor(room / (LETTER_SHARE * title.length))));
}

/** Axes in space. @param {any} scene @param {Colours} colours */
function dressScene(scene, colours) {
  const axis = (/** @type {any} */ one) => ({
    ...one, title: { ...one.title, text: titleInWords(axisTitle(one)), font: { size: 11 } }, color: colours.text, gridcolor: colours.grid, zerolinecolor: colours.line, showbackground: false, showspikes: false,
  });
  return { ...scene, xaxis: axis(scene.xaxis), yaxis: axis(scene.yaxis), zaxis: axis(scene.zaxis) };
}

/** @type {boolean | null} */
let inSpace = null;

/** Whether this browser can draw in space. */
export function drawsInSpace() {
  inSpace ??= Boolean(document.createElement("canvas").getContext("webgl"));
  return inSpace;
}

/**
 * Names in an annotation; of models in their colours the words behind each coloured square.
 * @param {string} text
 */
function annotationInWords(text) {
  if (!text.includes("</span>")) return saidNames(text);
  return text.replace(/(<\/span> )(.+?)(?= {2}|$)/g, (_, square, name) => square + said(name));
}

/**
 * Of ticks that were chosen for a wide chart those that have room on a narrow one.
 * @param {any} axis
 * @returns {{tickvals?: number[], ticktext?: string[]}}
 */
export function fewerTicks(axis) {
  /** @type {number[]} */
  const values = axis.tickmode === "array" && Array.isArray(axis.tickvals) ? axis.tickvals : [];
  if (values.length < 3 || !Array.isArray(axis.ticktext)) return {};
  const places = values.map((value) => (axis.type === "log" ? Math.log10(value) : value));
  const letters = Math.max(...axis.ticktext.flatMap((/** @type {string} */ text) => text.split("<br>").map((line) => line.length)));
  const room = ((letters + 1) * LETTER_PX / NARROWEST_PX) * (Math.max(...places) - Math.min(...places));
  /** @type {number[]} */
  const shown = [];
  places.forEach((place, i) => {
    if (!shown.length || Math.abs(place - (places[/** @type {number} */ (shown.at(-1))] ?? 0)) >= room) shown.push(i);
  });
  return { tickvals: shown.map((i) => /** @type {number} */ (values[i])), ticktext: shown.map((i) => axis.ticktext[i]) };
}

/**
 * Words of the server, or several names in a row.
 * @param {string} text
 */
function saidNames(text) {
  const whole = said(text);
  return whole === text ? text.split(", ").map(said).join(", ") : whole;
}

/**
 * @param {Trace} trace
 * @param {{colours: Colours, dark: boolean, hidden: Set<string>, named: boolean}} look
 * @returns {Trace}
 */
function dressTrace(trace, { colours, dark, hidden, named }) {
  const copy = { ...trace };
  if (trace.name) copy.name = traceName(trace);
  // The page's policy forbids what Plotly's WebGL needs; crowds are painted by `dots.js`.
  if (copy.type === "scattergl") copy.type = "scatter";
  if (trace.colorbar?.title?.text) copy.colorbar = { ...trace.colorbar, title: { ...trace.colorbar.title, text: said(trace.colorbar.title.text) } };
  const role = trace.meta?.role;
  const token = role ? /** @type {Record<string, keyof Colours>} */ (THEMED)[role] : undefined;
  const ownCurve = role === "series" && Boolean(trace.name) && !trace.meta?.label;
  copy.showlegend = trace.type === "bar" ? trace.name !== trace.meta?.label : (named || ownCurve) && trace.showlegend !== false;
  if (trace.type === "heatmap" || trace.type === "bar") {
    if (dark && copy.colorscale) copy.colorscale = copy.colorscale.map((/** @type {[number, string]} */ [at, colour]) => [at, onDark(colour)]);
    if (dark && typeof copy.marker?.color === "string") copy.marker = { ...copy.marker, color: onDark(copy.marker.color) };
    // Names of bars are words of the server; those of stations and runs are in no dictionary and stay.
    if (trace.type === "bar" && copy.orientation === "h" && Array.isArray(copy.y)) copy.y = copy.y.map((/** @type {unknown} */ word) => saidNames(String(word)));
    if (trace.type === "bar" && copy.orientation !== "h" && Array.isArray(copy.x) && typeof copy.x[0] === "string") copy.x = copy.x.map((/** @type {string} */ word) => said(word));
  } else if (token) {
    const colour = colours[token];
    if (copy.line) copy.line = { ...copy.line, color: colour };
    if (copy.marker) {
      // Where measurements lie thick they are darker.
      copy.marker = { ...copy.marker, color: role === "measurement" ? withAlpha(colour, 0.5) : colour };
      if (copy.marker.line) copy.marker.line = { ...copy.marker.line, color: colour };
    }
    // Numbers on lines of equal value lie on a coloured map and are read; the lines themselves may be faint.
    if (copy.textfont) copy.textfont = { ...copy.textfont, color: role === "bound" ? colours.text : colour };
    if (copy.fillcolor && role === "bound") copy.fillcolor = withAlpha(colour, 0.12);
  }
  // Rows of names begin with the entry's label, which stays; what follows may be words of the server.
  if (trace.type !== "bar" && Array.isArray(copy.y) && typeof copy.y[0] === "string" && trace.meta?.label) copy.y = copy.y.map((/** @type {string} */ row) => rowName(row, String(trace.meta?.label)));
  // The values stand in the strip under the chart; "none" hides the flying box but keeps the events.
  if (copy.hoverinfo !== "skip") {
    copy.hoverinfo = "none";
    delete copy.hovertemplate;
  }
  const label = trace.meta?.label;
  if (label && hidden.has(label)) copy.visible = false;
  return copy;
}

/** @param {string} row @param {string} label */
function rowName(row, label) {
  return row.startsWith(`${label}, `) ? `${label}, ${row.slice(label.length + 2).split(", ").map(said).join(", ")}` : row;
}

/**
 * The name of a curve in the page's language; an entry's label in it stays as it is.
 * @param {Trace} trace
 */
function traceName(trace) {
  const label = trace.meta?.label;
  if (!label) return said(trace.name);
  if (!trace.name.startsWith(`${label}, `)) return trace.name === label ? label : said(trace.name);
  // A single letter is a symbol: h is the altitude here and not an hour.
  if (trace.name.length === label.length + 3) return trace.name;
  // Between the label and the words may stand swept values.
  const at = trace.name.lastIndexOf(", ");
  const whole = said(trace.name.slice(label.length + 2));
  return whole === trace.name.slice(label.length + 2) ? `${trace.name.slice(0, at)}, ${said(trace.name.slice(at + 2))}` : `${label}, ${whole}`;
}

/** @param {string} colour */
function onDark(colour) {
  return /** @type {Record<string, string>} */ (SEQUENCE)[colour] ?? colour;
}

/**
 * @param {string} colour `rgb(r, g, b)` or `#rrggbb`
 * @param {number} alpha
 */
export function withAlpha(colour, alpha) {
  const hex = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(colour);
  const parts = hex ? hex.slice(1).map((part) => parseInt(part, 16)) : (colour.match(/[\d.]+/g) ?? []).slice(0, 3);
  return `rgba(${parts.join(", ")}, ${alpha})`;
}

/**
 * The title of an axis as plain text: "Horizontal error, m".
 * @param {any} axis
 */
export function axisTitle(axis) {
  const title = typeof axis?.title === "string" ? axis.title : (axis?.title?.text ?? "");
  return String(title).replace(/<[^>]*>/g, "");
}

/** An axis title in the page's language: known as a whole, or as the name of a parameter with its unit. @param {string} title */
function titleInWords(title) {
  const { quantity, unit } = splitTitle(title);
  const whole = said(title);
  return whole !== title || !unit ? whole : `${said(quantity)}, ${said(unit)}`;
}

/**
 * Split "Horizontal error, m" into the quantity and its unit.
 * @param {string} title
 */
export function splitTitle(title) {
  const at = title.lastIndexOf(",");
  return at < 0 ? { quantity: title, unit: "" } : { quantity: title.slice(0, at).trim(), unit: title.slice(at + 1).trim() };
}

/**
 * The row number in a point's customdata: the number itself, or the first of several.
 * @param {any} customdata
 * @returns {number | null}
 */
export function rowOf(customdata) {
  const value = Array.isArray(customdata) || ArrayBuffer.isView(customdata) ? /** @type {any} */ (customdata)[0] : customdata;
  return typeof value === "number" && Number.isFinite(value) && value >= 0 ? value : null;
}

/** Whether a figure's abscissa is time, so that all its entries can be read at one instant. @param {Figure} figure */
export function isOverTime(figure) {
  return axisTitle(figure.layout.xaxis).startsWith("Time");
}

/**
 * What the strip under a chart says of some points: the instant first, then a value for each entry.
 * @param {{trace: Trace, x: any, y: any, z?: any, text?: any, value?: any, of?: string}[]} points `of`: the track or target, where the line has several
 * @param {Record<string, any>} layout
 * @param {number | null} [time] the instant that is looked at
 * @returns {{name: string, value: string, colour: string | null}[]}
 */
export function describePoints(points, layout, time = null) {
  const upOf = (/** @type {Trace} */ trace) => splitTitle(axisTitle(layout[`yaxis${String(trace.yaxis ?? "y").slice(1)}`]));
  const colourOf = (/** @type {Trace} */ trace) => {
    const colour = trace.line?.color ?? trace.marker?.color;
    return typeof colour === "string" ? colour : null;
  };
  const said = new Set();
  const values = points.filter((point) => point.z !== null).map((point) => ({
    name: [point.trace.name, point.of].filter(Boolean).join(", "), value: typeof point.x === "string" ? categoryOf(point, upOf(point.trace).unit) : isOverTime({ data: [], layout }) ? valueOf(point, upOf(point.trace).unit) : placeOf(point, layout), colour: colourOf(point.trace),
  })).filter((part) => {
    const key = `${part.name} ${part.value}`;
    return !said.has(key) && said.add(key);
  });
  if (time === null) return values;
  return [{ name: t("chart.time"), value: `${formatNumber(time, 5)} ${t("unit.s")}`, colour: null }, ...instantOf(time, layout.meta?.start_utc), ...values];
}

/**
 * The value of a point that stands for a thing with a name: of a station.
 * @param {{x: any, y: any, text?: any}} point
 * @param {string} unit
 */
function categoryOf(point, unit) {
  const words = typeof point.text === "string" ? ` (${said(point.text)})` : "";
  return `${point.x}: ${formatQuantity(Number(point.y), unit)}${words}`;
}

/**
 * The place of a point in a plan.
 * @param {{x: any, y: any, value?: any, trace?: any, at?: number}} point
 * @param {Record<string, any>} layout
 */
function placeOf(point, layout) {
  if (layout.scene) {
    const up = formatNumber(Number(point.trace?.z?.[point.at ?? -1] ?? NaN), 5);
    return t("chart.place_in_space", { east: formatNumber(Number(point.x), 5), north: formatNumber(Number(point.y), 5), up, unit: said(splitTitle(axisTitle(layout.scene.xaxis)).unit) });
  }
  const unit = splitTitle(axisTitle(layout.xaxis)).unit;
  const place = t("chart.place", { east: formatNumber(Number(point.x), 5), north: formatNumber(Number(point.y), 5), unit: said(unit) });
  // A map has a value at every place.
  return typeof point.value === "number" ? `${formatNumber(point.value)} (${place})` : place;
}

/**
 * @param {{y: any, z?: any}} point a cell of a raster has its value in z and its row in y
 * @param {string} unit
 */
function valueOf(point, unit) {
  if (typeof point.z === "number") return `${point.y}: ${formatNumber(point.z)} %`;
  return typeof point.y === "number" ? formatQuantity(point.y, unit) : String(point.y);
}

/**
 * @param {number} time_s
 * @param {string | null | undefined} start
 */
function instantOf(time_s, start) {
  const origin = start ? Date.parse(start) : NaN;
  if (!Number.isFinite(origin) || !Number.isFinite(time_s)) return [];
  const iso = new Date(origin + time_s * 1000).toISOString();
  return [{ name: "UTC", value: iso.slice(11, 23), colour: null }];
}
