// The points of the folder on their axes, the selected point, and the columns that pictures can show.

const POINTS = TABLES.get("points") ?? null;

const grid = {
  /** For every axis: its entry in the head of the page, its values (ascending, SI), the unit of plots, the factor from SI, and `rank`, the index of each point's value. */
  axes: [],
  /** Index in HEAD.motions, by point. */
  motion: null,
  /** `point_id` of the points; null before `loadWords`. */
  ids: null,
  /** Row of the selected point; −1 if none is selected. */
  selected: -1,
  listeners: [],
};

async function loadGrid() {
  const columns = await POINTS.load(...HEAD.axes.map((axis) => axis.name), "direction");
  grid.directions = POINTS.column("direction");
  grid.motion = await numbers(HEAD.motion, Uint32Array);
  grid.axes = await Promise.all(HEAD.axes.map(async (axis, index) => {
    const values = await numbers(axis.values);
    const places = new Map(Array.from(values, (value, place) => [value, place]));
    const column = columns[index].values;
    const [factor, plotUnit] = plotted(axis, values);
    return { ...axis, values, column, rank: Int32Array.from(column, (value) => places.get(value) ?? -1), factor, plotUnit };
  }));
  if (HEAD.plane) grid.stands = await numbers(HEAD.plane.stands, Uint32Array);
}

/** Loads the columns that describe a point but that the first picture does not need. */
async function loadWords() {
  const [ids] = await POINTS.load("point_id", "status", "reason", "class", "period");
  grid.ids = ids.values;
}

/** `speed [rpm]`. */
function axisLabel(axis) {
  return `${axis.name} [${axis.plotUnit}]`;
}

/** Axes with several values, by place. */
function variedAxes() {
  return grid.axes.map((axis, index) => index).filter((index) => grid.axes[index].values.length > 1);
}

/** `load 0.1, speed 6000 rpm, sweep up`: where a point lies. */
function placeWords(row) {
  const shown = variedAxes().length > 0 ? variedAxes() : grid.axes.map((axis, index) => index);
  const words = shown.map((index) => `${grid.axes[index].name} ${axisText(grid.axes[index], grid.axes[index].column[row])}`);
  const direction = grid.directions?.text(row);
  return [...words, ...(direction ? [`sweep ${direction}`] : [])].join(", ");
}

/** Whether the motion of a point is transient chaos, so that its cell is hatched. */
function isHatched(row) {
  return HEAD.motions[grid.motion[row]].hatched;
}

/** The mark of points that have not converged. */
const OPEN = "?";

/** Whether a point has not converged: its cell has a question mark. */
function isOpen(row) {
  return HEAD.motions[grid.motion[row]].mark === OPEN;
}

/** Whether the standard errors of a point are not verified. Needs the column `errors_verified`. */
function isUnverified(row) {
  return POINTS.column("errors_verified")?.text(row) === "no";
}

/** Selects a point by its row, and updates all views that show it. */
function selectPoint(row) {
  if (row < 0 || row >= POINTS.rows) return;
  grid.selected = row;
  grid.listeners.forEach((listener) => listener(row));
}

/** Row of a point by its number; −1 where there is none. */
function rowOfPoint(point) {
  const [from, to] = [grid.ids.indexOf(point), grid.ids.lastIndexOf(point)];
  return from === to ? from : Math.max(from, -1);
}

/** Largest number of elements of a list among the options. */
const MOST_ELEMENTS = 40;

/** What maps and curves can show: `[value, text]` pairs in groups. A value is a column's name, or `name#element`. */
function shownColumns() {
  const groups = { Motion: [["class", "class and period"]], Numbers: [], "Elements of lists": [] };
  for (const column of POINTS.columns) {
    if (column.name === "status" || column.name === "kernel") groups.Motion.push([column.name, column.name]);
    const isAxis = HEAD.axes.some((axis) => axis.name === column.name);
    if (column.kind === "number" || column.kind === "whole") {
      if (column.name !== "point_id" && !isAxis) groups.Numbers.push([column.name, column.name]);
    }
    if (column.kind === "list") {
      for (let i = 0; i < Math.min(column.longest, MOST_ELEMENTS); i += 1) {
        groups["Elements of lists"].push([`${column.name}#${i}`, `${column.name}[${column.element(i)}]`]);
      }
    }
  }
  return Object.fromEntries(Object.entries(groups).filter(([, options]) => options.length > 0));
}

/** A column or an element of a list, with its values by row. Its standard errors are NaN before `loadErrors`. */
async function shownColumn(name) {
  const [columnName, element] = name.split("#");
  const column = POINTS.column(columnName);
  const errors = errorsOf(POINTS, columnName);
  await column.load();
  const index = Number(element ?? 0);
  return {
    name,
    title: element === undefined ? columnName : `${columnName}[${column.element(index)}]`,
    unit: column.unit,
    description: column.description,
    isMotion: name === "class",
    isText: column.kind === "text",
    loadErrors: () => errors?.load(),
    number: (row) => column.number(row, index),
    error: (row) => (errors?.isLoaded ? errors.number(row, index) : NaN),
    text: (row) => column.text(row) ?? "none",
  };
}

/** The lines of the box beside the pointer for a point. */
function pointLines(row, shown) {
  if (grid.ids === null) return [placeWords(row)];
  const motion = HEAD.motions[grid.motion[row]].name;
  const lines = [`point ${grid.ids[row]}`, placeWords(row)];
  if (!shown.isText) {
    const value = shown.number(row);
    lines.push(`${shown.title}: ${Number.isNaN(value) ? "no value" : withError(value, shown.error(row), shown.unit)}`);
  } else if (!shown.isMotion) {
    lines.push(`${shown.title}: ${shown.text(row)}`);
  }
  const status = POINTS.column("status")?.text(row);
  lines.push(status === "ok" ? motion : `${motion}, ${status}`);
  const reason = POINTS.column("reason")?.text(row);
  if (reason) lines.push(reason.length > 160 ? `${reason.slice(0, 160)} …` : reason);
  return lines;
}

/** The colour of the ramp at a fraction from 0 to 1. */
function rampColour(part) {
  const stops = HEAD.ramp;
  const place = Math.min(Math.max(part, 0), 1) * (stops.length - 1);
  const step = Math.min(Math.floor(place), stops.length - 2);
  const [a, b] = [rgb(stops[step]), rgb(stops[step + 1])];
  return a.map((from, i) => Math.round(from + (place - step) * (b[i] - from)));
}

/** Red, green and blue of `#rrggbb`. */
function rgb(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}
