// @ts-check
// What stands below the charts of a run: metrics, decisions, tracks, receivers, parameters, log, export.

import { h, put } from "../js/dom.js";
import { apiUrl, get, getText } from "../js/api.js";
import { language, metricName, said, t, told } from "../js/i18n.js";
import { formatBounds, formatCount, formatDuration, formatExact, formatNumber, formatQuantity, formatShare } from "../js/numbers.js";
import { swatch } from "../js/palette.js";
import { follow } from "../js/live.js";
import { recordingsOf, requestOf } from "../js/runs.js";
import { curlSnippet, pythonSnippet } from "../js/snippets.js";
import { loadTable } from "../js/tables.js";
import { dataTable } from "./data-table.js";
import { emptyState, failed, loading } from "./states.js";
import { copyText } from "./toast-area.js";

/** @import { ChartItem, Recording, Run, Scenario } from "../types.d.ts" */
/** @import { CursorBus } from "../js/cursor.js" */
/** @import { Row } from "../js/tables.js" */
/** @import { Column, DataTable } from "./data-table.js" */

// Smaller is better for these; more answers and more right ones are better. How many plots have a partner, a track or a place in an ellipse is no merit.
const SMALLER = /^((rms|median|p\d+|max)_.*|(?!accepted_|tracked_|inner_|middle_|outer_|manoeuvre_)\w+_share|probability_wrong|false_rejection|switches|false_tracks|ospa_m|gospa_.+)$/;
const LARGER = new Set(["answered_share", "tracked_share", "purity", "join_recall", "join_precision", "probability_correct", "assignment_correct", "recall", "precision"]);
// Tables whose rows are not of targets.
const WHOLE = new Set(["receivers", "receiver_delays", "emitters", "registration", "compared_tracks", "track_events", "gates"]);

/**
 * Load a table, then draw it; loading and failure stand in its place.
 * @param {Run} run
 * @param {string} name
 * @param {string} target only this one's rows; empty = of all
 * @param {(rows: Row[]) => Node} draw
 */
export function withTable(run, name, target, draw) {
  const box = h("div", null, loading());
  loadTable(run.id, name, target).then(({ rows, total }) => put(box, draw(rows), rows.length < total ? h("p", { class: "table-foot" },
    t("table.first_rows", { n: formatCount(rows.length) }), " ", h("a", { href: apiUrl(`runs/${run.id}/tables/${name}.csv`, { target }), download: "" }, t("table.all_as_csv"))) : null), (error) => put(box, h("div", { style: "padding: 12px" }, failed(error))));
  return box;
}

/** @param {string} column @returns {(row: Row) => number | null} */
function numberOf(column) {
  return (row) => {
    const value = row[column];
    return typeof value === "number" ? value : null;
  };
}

/** @param {Run} run @param {string} target */
export function metricsTab(run, target) {
  return withTable(run, "metrics", target, (all) => {
    const rows = all.filter((row) => String(row.target ?? "") === target);
    const labels = run.algorithms.map((entry) => entry.label ?? entry.name);
    const segments = [...new Set(rows.map((row) => String(row.segment ?? "")))];
    const body = h("div");
    let segment = segments.includes("") ? "" : (segments[0] ?? "");
    const draw = () => put(body, metricGrid(rows.filter((row) => String(row.segment ?? "") === segment), labels));
    const picker = segments.length < 2 ? null : h("label", { class: "row", style: "padding: 8px 12px" },
      h("span", { class: "muted" }, t("metrics.segment")),
      h("select", { style: "width: auto", value: segment, onchange: (/** @type {Event} */ event) => {
        segment = /** @type {HTMLSelectElement} */ (event.target).value;
        draw();
      } }, segments.map((value) => h("option", { value }, value || t("metrics.all")))));
    draw();
    return h("div", null, picker, body);
  });
}

/**
 * @param {Row[]} rows
 * @param {string[]} labels
 */
function metricGrid(rows, labels) {
  const names = [...new Set(rows.map((row) => String(row.metric)))];
  if (!names.length) return emptyState(t("metrics.none"));
  const anyInterval = rows.some((row) => row.ci95_low !== null && row.ci95_low !== undefined);
  return h("div", null,
    h("div", { class: "table-wrap", tabindex: 0, role: "region", "aria-label": t("tab.metrics") }, h("table", { data: { table: "metrics" } },
      h("caption", { class: "sr-only" }, t("tab.metrics")),
      h("thead", null, h("tr", null, h("th", { scope: "col" }, t("metrics.metric")),
        labels.map((label, i) => h("th", { scope: "col", class: "number" }, swatchInline(i), " ", label)), h("th", { scope: "col", class: "number" }, t("metrics.n")))),
      h("tbody", null, names.map((name) => {
        const own = labels.map((label) => rows.find((row) => row.metric === name && row.label === label));
        const best = bestOf(name, own.map((row) => (typeof row?.value === "number" ? row.value : null)));
        const counts = [...new Set(own.filter(Boolean).map((row) => row?.n))];
        return h("tr", null,
          h("th", { scope: "row", title: name }, metricName(name)),
          own.map((row) => h("td", { class: "number" }, row ? metricCell(row, best !== null && row.value === best) : "–")),
          h("td", { class: "number muted" }, counts.map((n) => formatCount(/** @type {number} */ (n))).join(" / ")));
      })))),
    anyInterval ? null : h("p", { class: "small muted", style: "padding: 6px 12px" }, t("metrics.no_interval")));
}

/** @param {number} index */
function swatchInline(index) {
  const line = swatch(index);
  line.setAttribute("style", "width: 22px; height: 8px; vertical-align: middle");
  return line;
}

/**
 * @param {Row} row
 * @param {boolean} best
 */
export function metricCell(row, best) {
  const value = /** @type {number | null} */ (row.value);
  const unit = String(row.unit ?? "");
  const share = String(row.metric).endsWith("_share");
  const text = share ? formatShare(value) : formatQuantity(value, unit);
  const low = /** @type {number | null} */ (row.ci95_low ?? null);
  const high = /** @type {number | null} */ (row.ci95_high ?? null);
  return [h("span", { class: best ? "best" : null }, text),
    low === null || high === null ? null : h("span", { class: "interval" }, ` ${formatBounds(low, high, value, share ? "share" : unit)}`)];
}

/**
 * The best value, where not all are the same.
 * @param {string} name
 * @param {(number | null)[]} values
 */
function bestOf(name, values) {
  const known = values.filter((value) => value !== null);
  if (known.length < 2 || !(SMALLER.test(name) || LARGER.has(name))) return null;
  const best = LARGER.has(name) ? Math.max(...known) : Math.min(...known);
  return known.every((value) => value === best) ? null : best;
}

/**
 * @param {Run} run
 * @param {string} target
 * @param {CursorBus} bus
 */
export function decisionsTab(run, target, bus) {
  return withTable(run, "decisions", target, (rows) => {
    if (!rows.length) return emptyState(t("decisions.none"));
    const known = (/** @type {string} */ name) => rows.some((row) => row[name] !== null && row[name] !== undefined && row[name] !== "");
    const columns = /** @type {Column<Row>[]} */ ([
      { title: t("table.label"), cell: (row) => row.label, sort: (row) => String(row.label) },
      ...(known("gate") ? [{ title: t("column.track"), number: true, cell: (/** @type {Row} */ row) => formatCount(numberOf("track")(row)), sort: numberOf("track") }] : []),
      { title: t("report.row"), number: true, cell: (row) => formatCount(numberOf("row")(row)), sort: numberOf("row") },
      { title: t("table.time"), number: true, cell: (row) => formatExact(roundTime(numberOf("time_s")(row))), sort: numberOf("time_s") },
      { title: t("decisions.decision"), cell: (row) => told(`decision.${row.decision}`, String(row.decision ?? "")), sort: (row) => String(row.decision) },
      { title: t("decisions.distance"), number: true, cell: (row) => formatNumber(numberOf("distance")(row)), sort: numberOf("distance") },
      { title: t("decisions.threshold"), number: true, cell: (row) => formatNumber(numberOf("threshold")(row)), sort: numberOf("threshold") },
      ...(known("probability") ? [{ title: t("decisions.probability"), number: true, cell: (/** @type {Row} */ row) => formatNumber(numberOf("probability")(row), 3), sort: numberOf("probability") }] : []),
      ...(known("gate") ? [
        { title: t("decisions.gate"), cell: (/** @type {Row} */ row) => told(`gate.${row.gate}`, String(row.gate ?? "")), sort: (/** @type {Row} */ row) => String(row.gate) },
        { title: t("decisions.competing"), cell: (/** @type {Row} */ row) => String(row.competing ?? ""), sort: (/** @type {Row} */ row) => String(row.competing ?? "") },
      ] : []),
      { title: t("decisions.reason"), wide: true, cell: (row) => h("span", { class: "break" }, row.reason === null ? "" : said(String(row.reason ?? ""))) },
    ]);
    const codes = [...new Set(rows.map((row) => String(row.decision)))];
    const labels = [...new Set(rows.map((row) => String(row.label)))];
    const chosen = { decision: "", label: "", track: "" };
    const table = dataTable({
      caption: t("tab.decisions"), columns, rows,
      onpick: (/** @type {Row} */ row) => {
        if (typeof row.time_s === "number") bus.look(row.time_s, { row: numberOf("row")(row), label: String(row.label), lock: true });
      },
      isCurrent: (row) => bus.now.row !== null && row.row === bus.now.row && (bus.now.label === null || row.label === bus.now.label),
    });
    table.dataset.table = "decisions";
    table.tall = true;
    followCursor(table, bus);
    const ofTrack = (/** @type {Row} */ row) => !chosen.track || String(row.track ?? "") === chosen.track || String(row.competing ?? "").split(" ").includes(chosen.track);
    const filter = () => table.setRows(rows.filter((row) => (!chosen.decision || row.decision === chosen.decision) && (!chosen.label || row.label === chosen.label) && ofTrack(row)));
    const count = (/** @type {string} */ code) => rows.filter((row) => row.decision === code).length;
    const choose = (/** @type {"decision" | "label"} */ field, /** @type {string[]} */ values, /** @type {(value: string) => string} */ words) => h("select", {
      style: "width: auto", "aria-label": t(field === "decision" ? "decisions.decision" : "table.label"), onchange: (/** @type {Event} */ event) => {
        chosen[field] = /** @type {HTMLSelectElement} */ (event.target).value;
        filter();
      },
    }, h("option", { value: "" }, t("decisions.all", { n: rows.length })), values.map((value) => h("option", { value }, words(value))));
    return h("div", null,
      h("div", { class: "row", style: "padding: 8px 12px" },
        choose("decision", codes, (code) => `${told(`decision.${code}`, code)} (${formatCount(count(code))})`),
        labels.length > 1 ? choose("label", labels, (label) => label) : null,
        known("gate") ? h("input", {
          type: "search", inputmode: "numeric", style: "width: 10em", placeholder: t("decisions.of_track"), "aria-label": t("decisions.of_track"),
          oninput: (/** @type {Event} */ event) => {
            chosen.track = /** @type {HTMLInputElement} */ (event.target).value.trim();
            filter();
          },
        }) : null,
        h("span", { class: "small muted" }, t("decisions.hint"))),
      table);
  });
}

/**
 * Bring the row of the mark that was clicked in a chart into view.
 * @param {DataTable} table
 * @param {CursorBus} bus
 */
function followCursor(table, bus) {
  bus.addEventListener("change", () => {
    if (!table.isConnected) return;
    // Redrawing on every hover would lose the focus in the table.
    if (!bus.now.locked && !table.querySelector("tr.current")) return;
    const focused = table.contains(document.activeElement);
    const found = table.turnTo((row) => table.isCurrent?.(row) ?? false);
    const current = table.querySelector("tr.current");
    if (found && current instanceof HTMLElement) {
      if (focused) current.focus({ preventScroll: true });
      const box = current.closest(".table-wrap");
      if (box instanceof HTMLElement) box.scrollTop = current.offsetTop - box.clientHeight / 2;
    }
  });
}

/** @param {number | null} time */
function roundTime(time) {
  return time === null ? null : Number(time.toFixed(3));
}

/**
 * Tracks; choosing one shows its target alone or, where nothing names targets, its time.
 * @param {Run} run
 * @param {string} target
 * @param {((name: string) => void) | null} choose null where there is nothing to choose
 * @param {(span: [number, number] | null) => void} look
 */
export function tracksTab(run, target, choose, look) {
  return withTable(run, "tracks", target, (rows) => {
    if (!rows.length) return emptyState(t("tracks.none"));
    const spans = new Set(rows.map((row) => `${row.start_s} ${row.end_s}`));
    const byTarget = choose && !target ? choose : null;
    const byTime = !byTarget && spans.size > 1;
    /** @type {Row | null} */
    let shown = null;
    const table = dataTable({
      caption: t("tab.tracks"), rows, columns: plainColumns(rows), isCurrent: (row) => row === shown,
      ...(byTarget ? { onpick: (/** @type {Row} */ row) => { if (row.target) byTarget(String(row.target)); } } : {}),
      ...(byTime ? { onpick: (/** @type {Row} */ row) => {
        shown = row === shown ? null : row;
        look(shown && spanOf(shown));
        table.draw();
        // The row was drawn anew: the keyboard stays on it.
        table.focusOn(table.querySelectorAll("tbody tr")[table.ordered().indexOf(row) - table.page * table.pageRows]);
      } } : {}),
    });
    table.dataset.table = "tracks";
    const hint = byTarget ? t("tracks.hint") : byTime ? t("tracks.hint_time") : null;
    return h("div", null, hint ? h("p", { class: "small muted", style: "padding: 8px 12px 0" }, hint) : null, table);
  });
}

/** The time of a track with a little before and after; null where it is unknown. @param {Row} row @returns {[number, number] | null} */
function spanOf(row) {
  const [start, end] = [numberOf("start_s")(row), numberOf("end_s")(row)];
  if (start === null || end === null) return null;
  const margin = 0.05 * (end - start) || 1;
  return [start - margin, end + margin];
}

/**
 * What is said of the receivers is said of all marks.
 * @param {Run} run
 * @param {string} target
 */
export function receiversTab(run, target) {
  return withTable(run, "receivers", "", (rows) => h("div", null,
    target ? h("p", { class: "small muted", style: "padding: 8px 12px 0" }, t("receivers.of_all_targets")) : null,
    rows.length ? dataTable({ caption: t("tab.receivers"), rows, columns: plainColumns(rows) }) : emptyState(t("receivers.none"))));
}

/**
 * Columns of any table of a run: titles from the dictionary, numbers with the precision they deserve.
 * @param {Row[]} rows
 * @returns {Column<Row>[]}
 */
function plainColumns(rows) {
  return Object.keys(rows[0] ?? {}).filter((name) => rows.some((row) => row[name] !== null && row[name] !== "")).map((name) => {
    const number = rows.some((row) => typeof row[name] === "number");
    return {
      title: told(`column.${name}`, name),
      number,
      wide: name === "reason" || name === "doubts",
      cell: (/** @type {Row} */ row) => {
        const value = row[name] ?? null;
        if (typeof value === "number") return Number.isInteger(value) ? formatCount(value) : formatNumber(value, 4);
        if (typeof value === "boolean") return t(value ? "form.yes" : "form.no");
        // A name that breaks anywhere would become a column of letters beside many numbers.
        if (name === "label") return h("span", { class: "entry-name" }, String(value ?? ""));
        if (name === "doubts") return h("span", { class: "break" }, String(value ?? "").split(" ").filter(Boolean).map((code) => told(`doubt.${code}`, code)).join("; "));
        return h("span", { class: "break" }, value === null ? "" : told(`decision.${value}`, value));
      },
      sort: (/** @type {Row} */ row) => /** @type {string | number | null} */ (row[name] ?? null),
    };
  });
}

/** A choice is the name that scripts use, as the parameter's own is. @param {any} value */
const used = (value) => typeof value === "string" ? h("code", null, value) : formatExact(value);

/** @param {Run} run */
export function parametersTab(run) {
  return h("div", { class: "stack", style: "padding: 12px" }, run.algorithms.map((entry, i) => {
    const label = entry.label ?? entry.name;
    const settings = Object.entries(run.settings?.[label] ?? {});
    const notes = run.notes?.[label] ?? [];
    const seconds = run.seconds?.[label];
    return h("section", { class: "stack", "aria-label": label },
      h("div", { class: "row" }, swatch(i), h("h3", { class: "break" }, label), h("a", { href: `#/algorithms/${encodeURIComponent(entry.name)}` }, entry.name),
        seconds ? h("span", { class: "muted small" }, formatDuration(seconds)) : null),
      notes.length ? h("ul", { class: "notice stack tight" }, notes.map((note) => h("li", null, said(note.detail), note.count > 1 ? h("span", { class: "muted" }, ` (${formatCount(note.count)}×)`) : null))) : null,
      settings.length ? h("div", { class: "table-wrap", tabindex: 0, role: "region", "aria-label": `${t("tab.parameters")}: ${label}` }, h("table", { data: { table: "settings" } },
        h("thead", null, h("tr", null, h("th", { scope: "col" }, t("algorithms.parameter")), h("th", { scope: "col", class: "number" }, t("parameters.used")), h("th", { scope: "col" }, t("parameters.source")))),
        h("tbody", null, settings.map(([name, setting]) => h("tr", null,
          h("th", { scope: "row" }, h("code", null, name)),
          h("td", { class: "number" }, setting.source === "run" ? h("b", null, used(setting.value)) : used(setting.value)),
          h("td", null, told(`source.${setting.source}`, setting.source)))))))
        : h("pre", null, JSON.stringify(entry.parameters ?? {}, null, 1)));
  }));
}

/** A line of the log, with what it says in the page's language; lines of a trace stay. @param {string} line */
function logLine(line) {
  const [, head = "", text = ""] = /^(\S+Z \w+ +)(.*)$/.exec(line) ?? [];
  return text ? head + said(text) : line;
}

/** @param {Run} run @param {EventTarget | null} [news] tells of more trials */
export function logTab(run, news = null) {
  const box = h("div", { style: "padding: 12px" }, loading());
  let before = "";
  const load = () => getText(`runs/${run.id}/log`).then(
    (text) => {
      if (text && text === before) return;
      before = text;
      put(box, text.trim() ? h("pre", null, text.split("\n").map(logLine).join("\n")) : emptyState(t("log.none")));
    },
    (error) => { if (!before) put(box, failed(error, { retry: load })); });
  load();
  if (news) follow(news, box, load);
  return box;
}

/** Where the stations of a run stand: as its recording says, or its scenario. @param {Run} run @returns {Promise<Pick<Recording, "site" | "options">>} */
async function frameOf(run) {
  // Joined recordings are in the frame of the first.
  const [recording] = recordingsOf(run);
  if (recording) return get(`recordings/${recording}`);
  const { preset, parameters = {} } = /** @type {{preset: string, parameters?: Record<string, any>}} */ (run.source.scenario);
  const { properties } = /** @type {Scenario} */ (await get(`scenarios/${preset}`)).parameters_schema;
  const given = (/** @type {string} */ name) => parameters[name] ?? properties?.[name]?.default;
  return { site: /** @type {any} */ ({ origin: given("origin"), stations: given("stations") }), options: {} };
}

/** Whether a local frame has an origin. @param {Pick<Recording, "site" | "options">} frame */
function isOnTheGlobe({ site, options }) {
  const places = [site?.stations, site?.radars, site?.transmitters, site?.receivers].flatMap((one) => one ?? []);
  return Boolean(site?.origin ?? options?.origin) || places.some((place) => place.latitude_deg != null);
}

/**
 * @param {Run} run
 * @param {ChartItem[]} charts
 * @param {string[]} tables
 * @param {string} target
 */
export function exportTab(run, charts, tables, target) {
  // Pages are written in the language of this one.
  const spoken = (/** @type {string} */ suffix) => (suffix === "html" && language() !== "en" ? { language: language() } : {});
  const links = (/** @type {string} */ path, /** @type {string[]} */ suffixes, only = target) => suffixes.map((suffix) => h("a", { href: apiUrl(`runs/${run.id}/${path}.${suffix}`, { target: only, ...spoken(suffix) }), download: "" }, suffix.toUpperCase()));
  const file = (/** @type {string} */ name) => h("a", { href: apiUrl(`runs/${run.id}/${name}`, spoken(name.split(".").pop() ?? "")), download: "" }, name);
  // A frame without a place on the globe has no tracks there; its file would only say so.
  const tracksOf = () => {
    const place = h("dd", { class: "row" }, t("state.loading"));
    frameOf(run).then(
      (frame) => put(place, isOnTheGlobe(frame) ? links("tracks", ["geojson", "kml"]) : h("span", { class: "muted" }, t("export.no_origin"))),
      () => put(place, links("tracks", ["geojson", "kml"])));
    return place;
  };
  const snippet = (/** @type {string} */ title, /** @type {string} */ text) => h("div", { class: "stack tight" },
    h("div", { class: "row" }, h("h3", null, title), h("button", { class: "link small", type: "button", onclick: () => copyText(text) }, t("action.copy"))), h("pre", { class: "card", style: "padding: 8px" }, text));
  const base = new URL("./", document.baseURI).href;
  return h("div", { class: "columns", style: "padding: 12px" },
    h("div", { class: "stack" },
      target ? h("p", { class: "small muted" }, t("export.of_target", { name: target })) : null,
      h("h3", null, t("export.tables")),
      h("dl", { class: "pairs" }, tables.flatMap((name) => [h("dt", null, h("code", null, name)), h("dd", { class: "row" },
        links(`tables/${name}`, ["csv", "json", "parquet"], WHOLE.has(name) ? "" : target))])),
      h("h3", null, t("export.charts")),
      h("dl", { class: "pairs" }, charts.flatMap((chart) => [h("dt", null, told(`chart.${chart.name}`, chart.title)), h("dd", { class: "row" }, links(`charts/${chart.name}`, ["csv", "json", "html"]))])),
      h("h3", null, t("export.whole")),
      h("dl", { class: "pairs" },
        h("dt", null, t("export.report")), h("dd", { class: "row" }, file("report.html")),
        h("dt", null, t("export.tracks")), tracksOf(),
        h("dt", null, t("export.arrays")), h("dd", { class: "row" }, file("result.npz"), file("result.mat")))),
    h("div", { class: "stack" }, snippet("curl", curlSnippet(base, requestOf(run))), snippet("Python", pythonSnippet(base, requestOf(run)))));
}
