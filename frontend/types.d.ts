// What the HTTP API gives and takes, as the page uses it. Written by hand; docs of the API: /docs.

export type RunState = "queued" | "running" | "succeeded" | "failed" | "cancelled";
export type RecordingState = "parsing" | "ready" | "failed";

export interface Page<T> {
  items: T[];
  next_cursor?: string | null;
}

export interface ProblemBody {
  type?: string;
  title?: string;
  status?: number;
  detail?: string;
  code?: string;
  remedy?: string;
  errors?: FieldError[];
}

export interface FieldError {
  pointer: string;
  detail: string;
  code?: string;
}

export interface EngineStatus {
  state: "starting" | "warming_up" | "ready" | "failed" | "stopped";
  workers: number;
  running: number;
  queued: number;
  detail?: string | null;
  warning?: string;
}

export interface Meta {
  name: string;
  version: string;
  licence: string;
  plotly_js: string;
  versions: Record<string, string>;
  limits: { max_upload_bytes: number; max_json_bytes: number; max_rows: number };
  engine: EngineStatus;
  disk_free_bytes: number;
  started_at: string;
}

export interface Station {
  name: string;
  east_m?: number | null;
  north_m?: number | null;
  up_m?: number | null;
  latitude_deg?: number | null;
  longitude_deg?: number | null;
  height_m?: number | null;
  sigma_toa_ns?: number | null;
  clock_offset_ns?: number | null;
  [more: string]: unknown;
}

export interface Site {
  origin?: { latitude_deg: number; longitude_deg: number; height_m?: number } | null;
  stations?: Station[];
  radars?: Station[];
  transmitters?: Station[];
  receivers?: Station[];
  [more: string]: unknown;
}

export interface Rejection {
  row: number | null;
  code: string;
  detail: string;
  file?: string | null;
}

export interface ReadWarning {
  code: string;
  detail: string;
  count: number;
}

export interface Recording {
  id: string;
  name: string;
  kind: string | null;
  format: string | null;
  sha256: string;
  state: RecordingState;
  rows: { read: number; accepted: number; rejected: number };
  rejections?: Rejection[];
  rejections_url?: string;
  time_span_s: [number, number] | number | null;
  start_utc?: string | null;
  site: Site | null;
  has_truth: boolean;
  warnings: ReadWarning[];
  files?: { role: string; name: string; size: number; sha256?: string }[];
  error?: ProblemBody | null;
  created_at?: string;
  size_bytes?: number;
  options?: Record<string, unknown>;
}

export interface ColumnSource {
  column: string;
  unit?: string | null;
  minus?: string | null;
}

/** How files are to be read. */
export interface ReadOptions {
  name?: string | null;
  kind?: string | null;
  mapping?: Record<string, ColumnSource | string>;
  where?: Record<string, string | number | boolean>;
  [other: string]: unknown;
}

/** An option of reading that means something for a file. */
export interface ReadOption {
  name: string;
  values: string[];
  is_number: boolean;
  description: string;
}

/** A look into a file before it is read. */
export interface Preview {
  format: string | null;
  columns: string[];
  rows: string[][];
  suggestion: { kind: string | null; mapping: Record<string, ColumnSource> };
  trial: {
    kind: string;
    format: string;
    rows: { read: number; accepted: number; rejected: number };
    rejections: Rejection[];
    warnings: ReadWarning[];
    time_span_s: [number, number];
  } | null;
  error: { code: string; detail: string; remedy: string; pointer: string } | null;
  native_columns: Record<string, { name: string; units: string[] }[]>;
  options: ReadOption[];
}

/** What a run would take. */
export interface RunEstimate {
  seconds: number | null;
  memory_bytes: number | null;
  queue_position: number;
  basis: { label: string; seconds: number | null; measured: number }[];
  /** Why it cannot start; then nothing else is told. */
  errors: FieldError[];
}

export interface ParameterSchema {
  title?: string;
  description?: string;
  type?: string | string[];
  anyOf?: ParameterSchema[];
  allOf?: ParameterSchema[];
  enum?: (string | number | boolean | null)[];
  const?: unknown;
  $ref?: string;
  default?: unknown;
  minimum?: number;
  maximum?: number;
  exclusiveMinimum?: number;
  exclusiveMaximum?: number;
  unit?: string;
  symbol?: string;
  group?: string;
  advanced?: boolean;
  from_site?: string;
  fallback?: unknown;
  choices?: Record<string, string>;
  labels_from?: string;
  row_sum?: number;
  items?: ParameterSchema;
  prefixItems?: ParameterSchema[];
  properties?: Record<string, ParameterSchema>;
}

export interface ParametersSchema {
  properties?: Record<string, ParameterSchema>;
  $defs?: Record<string, ParameterSchema>;
}

export interface Reference {
  key: string;
  place?: string;
  text?: string;
  [more: string]: unknown;
}

export interface Output {
  name: string;
  axes: string[];
  unit?: string;
  meaning?: string;
  categories?: string[];
}

export interface Scenario {
  name: string;
  title: string;
  summary: string;
  family: string;
  kind: string;
  parameters_schema: ParametersSchema;
  references: Reference[];
}

/** Simulated trials as the source of a run. */
export interface TrialsRequest {
  scenario: { preset: string; parameters?: Record<string, unknown> };
  trials: number;
  seed: number;
  sweep?: Record<string, unknown[]>;
}

/** A reproduction of a figure or claim of a paper. */
export interface Study {
  name: string;
  title: string;
  summary: string;
  family: string;
  paper: Reference;
  item: string;
  scenario: string;
  trials: number;
  seed: number;
  claims: { figure: string; claim: string; paper: string }[];
}

/** Recorded tracks as the targets of a preset. */
export interface TracksScenario {
  preset: string;
  parameters: Record<string, unknown>;
  tracks: { name: string; reports: number; points: number; first_s: number; last_s: number; left_out: Record<string, number>; problem: string }[];
  tracks_found: number;
  start_utc: string | null;
}

export interface ScenarioPreview {
  rows: number;
  unheard: number;
  complete_share: number | null;
  time_span_s: [number, number];
  targets: string[];
  legs: { name: string; start_s: number; stop_s: number }[];
  site: Site;
  charts: Record<string, Figure>;
}

export interface AccuracyMap {
  variant: string;
  quantity: string;
  unit: string;
  stations: string[];
  site: Omit<Site, "stations"> & { origin?: any; stations: { name: string; east_m?: number; north_m?: number; up_m?: number; sigma_toa_ns?: number }[] };
  places: { name: string; east_m: number; north_m: number; up_m: number }[];
  origin: Record<string, number> | null;
  altitude_m: number;
  sigma_altitude_m: number;
  east_m: { start_m: number; stop_m: number; count: number };
  north_m: { start_m: number; stop_m: number; count: number };
  observable_share: number;
  median: number | null;
  chart: Figure;
  clocks: { station: string; median_m_per_ns: number | null; largest_m_per_ns: number | null }[];
  subsets: { stations: string[]; observable_share: number; median: number | null; quantile_90: number | null; common_ratio: number | null }[] | null;
}

export interface Algorithm {
  name: string;
  title: string;
  summary: string;
  family: string;
  recommended: boolean;
  takes: string[];
  parameters_schema: ParametersSchema;
  outputs: Output[];
  charts: string[];
  references: Reference[];
}

export interface RunEntry {
  name: string;
  label?: string;
  parameters?: Record<string, unknown>;
}

export interface SummaryValue {
  value: number | null;
  ci95: [number, number] | null;
  unit: string;
}

export type Summary = Record<string, Record<string, SummaryValue>>;

export interface Run {
  id: string;
  state: RunState;
  progress: { done: number; total: number; eta_s?: number | null };
  algorithms: RunEntry[];
  source: { recording_id?: string; recording_ids?: string[]; name?: string; study?: string; [more: string]: unknown };
  seed: number | null;
  trials: number | null;
  label: string | null;
  tags: string[];
  created_at: string;
  started_at: string | null;
  finished_at: string | null;
  error: ProblemBody | null;
  /** In lists only the metrics of which the first stands for the run. */
  summary: Summary | null;
  /** What the algorithms cite. This, settings, notes and seconds are not in lists. */
  references?: Reference[] | null;
  software?: Record<string, unknown>;
  /** By label: every parameter as it was used. */
  settings?: Record<string, Record<string, { value: unknown; source: string }>> | null;
  /** By label: what must be known about the result. */
  notes?: Record<string, { code: string; detail: string; count: number }[]> | null;
  seconds?: Record<string, number> | null;
  queue_position?: number | null;
  /** Disk that the result takes. */
  size_bytes?: number | null;
}

/** Several runs side by side; each list of values has one for each entry. */
export interface Comparison {
  runs: { id: string; title: string; label: string; tags: string[]; created_at: string; recording_id: string; recording_name: string }[];
  entries: { index: number; label: string; run_id: string; entry: string; algorithm: string; seconds: number | null }[];
  same_recording: boolean;
  given: { name: string; values: unknown[]; differs: boolean }[];
  parameters: { name: string; values: ({ value: unknown; source: string } | null)[]; differs: boolean }[];
  software: { name: string; values: unknown[]; differs: boolean }[];
  targets: string[];
  segments: string[];
  metrics: { metric: string; unit: string; values: ({ value: number | null; ci95: [number, number] | null; n: number | null } | null)[]; differs: boolean; best: number[] }[];
  charts: { name: string; title: string; obstacle: string | null }[];
}

/** A target of a recording; a comparison knows only the name. */
export interface Target {
  name: string;
  marks?: number;
  time_span_s?: [number, number];
}

export interface ChartItem {
  name: string;
  title: string;
}

export type Cell = string | number | boolean | null;

export interface TableData {
  columns: string[];
  rows: Cell[][];
  /** Rows of the whole table. */
  total?: number;
}

export interface TraceMeta {
  /** Names of the unbroken pieces of a line: targets, or numbers of tracks. */
  pieces?: (string | number)[];
  /** How the page paints the markers of a crowd. */
  dot?: { symbol: string; size: number; colour: string; opacity: number; stroke: number };
  role?: "series" | "truth" | "station" | "measurement" | "bound" | "interval" | "rejected";
  label?: string | null;
  index?: number;
}

// The part of Plotly's objects that the page reads or sets.
export type Trace = Record<string, any> & { meta?: TraceMeta };
export interface Figure {
  data: Trace[];
  layout: Record<string, any>;
}

export interface PlotlyElement extends HTMLElement {
  data?: Trace[];
  layout?: Record<string, any>;
  _fullLayout?: Record<string, any>;
  _fullData?: Trace[];
  on?(event: string, handler: (event: any) => void): void;
}

export interface PlotlyLibrary {
  react(element: HTMLElement, data: Trace[], layout: object, config?: object): Promise<void>;
  relayout(element: HTMLElement, update: object): Promise<void>;
  purge(element: HTMLElement): void;
  toImage(figure: Figure & { config?: object }, options: object): Promise<string>;
  register(module: object): void;
  Plots: { resize(element: HTMLElement): void };
}

declare global {
  interface Window {
    Plotly?: PlotlyLibrary;
  }
}
