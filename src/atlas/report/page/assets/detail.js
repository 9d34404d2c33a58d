// The selected point: all its columns, its Poincaré section, spectra and basins, and its rows of other tables.

/** Tables with a picture. For all other tables, the rows of the point are shown. */
const PICTURED = ["points", "poincare", "spectra", "basins"];
/** Largest number of shown rows of a table. */
const MOST_ROWS = 100;

const detail = { charts: [], section: "", signal: "", over: "order", asked: 0 };

function startDetail() {
  const box = document.getElementById("detail");
  const step = (by) => () => selectPoint(Math.min(Math.max(grid.selected + by, 0), POINTS.rows - 1));
  const number = make("input", {
    id: "point-number", type: "number", min: "0", "aria-label": "Number of the point", onchange: async () => {
      await loadWords();
      const row = rowOfPoint(Number(number.value));
      number.setCustomValidity(row < 0 ? "There is no point with this number." : "");
      number.reportValidity();
      if (row >= 0) selectPoint(row);
    },
  });
  box.append(
    make("div", { class: "stepper" },
      make("button", { type: "button", id: "before", "aria-label": "Previous point", onclick: step(-1) }, "‹"),
      make("label", {}, make("span", {}, "Point"), number),
      make("button", { type: "button", id: "after", "aria-label": "Next point", onclick: step(1) }, "›")),
    make("div", { id: "point", "aria-live": "polite" }),
    make("div", { id: "evidence" }),
    make("div", { id: "pictures" }),
    make("div", { id: "rows" }),
    make("div", { id: "statistics" }),
  );
  grid.listeners.push(showPoint);
}

async function showPoint(row) {
  detail.asked += 1;
  const asked = detail.asked;
  await loadWords();
  const shown = map.chart ? await shownColumn(map.column) : null;
  await shown?.loadErrors();
  // Another point may have been selected meanwhile.
  if (asked !== detail.asked) return;
  document.getElementById("point-number").value = grid.ids[row];
  const motion = HEAD.motions[grid.motion[row]];
  const value = shown === null || shown.isText ? "" : withError(shown.number(row), shown.error(row), shown.unit);
  document.getElementById("point").replaceChildren(
    make("h2", {}, `Point ${grid.ids[row]}`),
    make("p", {}, placeWords(row)),
    make("p", { class: "motion" }, swatch(motion.colour, motion.hatched), motion.name, ` · ${POINTS.column("status").text(row)}`),
    value === "" ? "" : make("p", {}, `${shown.title}: ${value}`),
    make("p", { class: "reason" }, POINTS.column("reason").text(row) ?? ""),
  );
  await POINTS.load();
  if (asked !== detail.asked) return;
  document.getElementById("evidence").replaceChildren(...evidence(row));
  document.getElementById("statistics").replaceChildren(statistics(row));
  detail.charts.forEach((chart) => chart.remove());
  detail.charts = [];
  const [pictures, rows] = [document.getElementById("pictures"), document.getElementById("rows")];
  pictures.replaceChildren();
  rows.replaceChildren();
  for (const [name, show] of [["poincare", showSection], ["spectra", showSpectrum], ["basins", showBasins]]) {
    const table = TABLES.get(name);
    if (table === undefined) continue;
    const [from, to] = await table.rowsOf(grid.ids[row]);
    if (from < to) await table.load();
    if (asked !== detail.asked) return;
    const place = make("div", { class: "picture" });
    pictures.append(place);
    if (from < to) show(table, from, to, place);
    else if (table.rows < table.all) place.append(make("p", { class: "soft" }, `This page has no rows of ${name} for this point; they were left out, or there are none.`));
  }
  for (const table of TABLES.values()) {
    if (PICTURED.includes(table.name) || table.column("point_id") === null) continue;
    const [from, to] = await table.rowsOf(grid.ids[row]);
    if (from < to) await table.load();
    if (asked !== detail.asked) return;
    if (from < to) rows.append(rowsOf(table, from, to));
  }
}

/** The evidence for a motion that does not settle: lifetime of its chaos, and size of the sample. */
function evidence(row) {
  const number = (name) => POINTS.column(name)?.number(row) ?? NaN;
  const [low, high, life] = ["low", "high", ""].map((end) => number(end === "" ? "chaos_lifetime" : `chaos_lifetime_${end}`));
  const cycles = (value) => count(Math.round(value));
  const told = [];
  if (!Number.isNaN(life)) {
    told.push(["life of chaos", `${cycles(life)} mesh cycles (95 %: ${cycles(low)} … ${cycles(high)})`]);
  } else if (!Number.isNaN(low)) {
    told.push(["life of chaos", `at least ${cycles(low)} mesh cycles (95 %); no trajectory left it`]);
  }
  const endings = POINTS.column("ended_on")?.text(row);
  if (endings) told.push([`${count(number("chaos_exits"))} of ${count(number("trajectories"))} trajectories ended on`, endings.replaceAll("_", " ")]);
  const verified = POINTS.column("errors_verified")?.text(row);
  if (verified) told.push(["standard errors", verified === "yes" ? "verified" : "not verified"]);
  const others = [
    ["trajectories", "trajectories"], ["correlation_cycles", "correlation, in mesh cycles"], ["ess", "effective sample size"],
    ["rhat", "split R-hat"], ["rotation_number", "rotation number"],
  ];
  for (const [name, words] of others) {
    if (!Number.isNaN(number(name))) told.push([words, digits(number(name))]);
  }
  if (told.length === 0) return [];
  const lines = told.map(([name, text]) => make("tr", {}, make("th", { scope: "row" }, name), make("td", {}, text)));
  return [make("h3", {}, "Evidence"), make("table", { class: "statistics" }, make("tbody", {}, lines))];
}

/** Unit of a value. In tables of several signals, the row gives the unit. */
function unitOf(table, column, row) {
  return (column.unit.includes(" or ") && table.column("unit")?.text(row)) || column.unit;
}

/** A value as text with its unit; a list with the names of its elements. */
function valueText(table, column, row) {
  if (column.kind === "text") return column.text(row) ?? "";
  const errors = errorsOf(table, column.name);
  if (column.kind === "whole") return Number.isNaN(column.values[row]) ? "" : count(column.values[row]);
  const axis = HEAD.axes?.find((own) => own.name === column.name);
  if (axis) return axisText(axis, column.values[row]);
  if (column.kind === "number") return withError(column.values[row], errors?.number(row) ?? NaN, unitOf(table, column, row));
  const list = column.list(row);
  if (list === null) return "";
  const most = 16;
  const texts = Array.from(list.subarray(0, most), (value, index) => {
    const text = withError(value, errors?.number(row, index) ?? NaN, column.unit);
    return column.elements ? `${column.element(index)}: ${text}` : text;
  });
  return texts.join(", ") + (list.length > most ? `, … (${plural(list.length, "value")})` : "");
}

/** Whether a column only holds the standard errors of another. */
function isError(table, name) {
  if (name === "lambda_stderr" && table.column("lambda_max") !== null) return true;
  const own = name.replace(/_stderr$/, "");
  return own !== name && table.column(own) !== null;
}

/** All columns of a point. */
function statistics(row) {
  const columns = POINTS.columns.filter((column) => column.has(row) && !isError(POINTS, column.name));
  const told = columns.map((column) => [column.name, valueText(POINTS, column, row), column.description]);
  const table = describedTable(told);
  const filter = make("input", {
    type: "search", id: "statistics-filter", placeholder: "filter", "aria-label": "Filter of the statistics", oninput: () => {
      const wanted = filter.value.toLowerCase();
      [...table.rows].forEach((line, i) => { line.hidden = !told[i].join(" ").toLowerCase().includes(wanted); });
    },
  });
  const absent = POINTS.columns.length - columns.length - POINTS.columns.filter((c) => c.has(row) && isError(POINTS, c.name)).length;
  return make("div", {},
    make("h3", {}, "Statistics"), filter,
    table,
    absent > 0 ? make("p", { class: "soft" }, `${plural(absent, "more column")} without a value at this point.`) : null);
}

/** The rows of a table that belong to one point, as an element. */
function rowsOf(table, from, to) {
  const columns = table.columns.filter((column) => column.name !== "point_id" && !isError(table, column.name));
  const rows = Array.from({ length: Math.min(to - from, MOST_ROWS) }, (_, i) => from + i);
  const heads = columns.map((column) => column.name);
  const texts = rows.map((row) => columns.map((column) => valueText(table, column, row)));
  const more = to - from > MOST_ROWS ? `, the first ${MOST_ROWS} shown` : "";
  return make("details", { open: to - from <= 12 },
    make("summary", {}, `${table.name}: ${plural(to - from, "row")}${more}`),
    plainTable(table.name, heads, texts, (column) => columns[column].kind !== "text"));
}

/** Fills `place` with a heading, controls and an element for a chart. Returns this element. */
function picture(place, title, controls) {
  const host = make("div", { class: "plot small", role: "img", "aria-label": `point ${grid.ids[grid.selected]} (${placeWords(grid.selected)}): ${title}` });
  place.replaceChildren(make("h3", {}, title), make("div", { class: "controls" }, controls), host);
  return host;
}

/** The Poincaré samples of a point: velocity over deflection. */
function showSection(table, from, to, place) {
  const [kinds, deflections, velocities] = ["section", "deflection", "velocity"].map((name) => table.column(name));
  const rows = Array.from({ length: to - from }, (_, i) => from + i);
  const all = [...new Set(rows.map((row) => kinds.text(row)))];
  const kind = all.includes(detail.section) ? detail.section : all[0];
  const own = rows.filter((row) => kinds.text(row) === kind);
  const options = all.map((name) => [name, name.replaceAll("_", " ")]);
  const host = picture(place, `Poincaré section (${kind.replaceAll("_", " ")}): ${plural(own.length, "sample")}`, choice("Samples", options, kind, (value) => {
    detail.section = value;
    showSection(table, from, to, place);
  }, "section-kind"));
  plotPlaces(host, own, deflections, velocities, ["cycle", "phase"].map((name) => table.column(name)));
}

/** A scatter plot of two columns over some rows. The box beside the pointer also shows the other columns. */
function plotPlaces(host, rows, across, up, others) {
  const [x, y] = [across, up].map((column) => {
    const values = rows.map((row) => column.values[row]);
    const [factor, unit] = scaledUnit(column.unit, Math.max(...(extent(values) ?? [1]).map(Math.abs)));
    return { values: values.map((value) => value * factor), label: `${column.name} [${unit}]` };
  });
  const size = rows.length > 3000 ? 1.5 : rows.length > 300 ? 2.5 : 4;
  const chart = new Chart(host, {
    height: 260,
    x: { label: x.label, range: padded(extent(x.values)) },
    y: { label: y.label, range: padded(extent(y.values)) },
    draw: (pen) => pen.dots(x.values, y.values, themed("accent"), size),
    pick: (left, top, pen) => rows[pen.nearest(x.values, y.values, left, top)] ?? null,
    tip: (row) => [across, up, ...others].filter((column) => column).map((column) =>
      `${column.name}: ${column.kind === "number" ? withUnit(column.values[row], column.unit) : count(column.values[row])}`),
  });
  detail.charts.push(chart);
}

/** The lines of a spectrum, over the order of the mesh or over frequency. */
function showSpectrum(table, from, to, place) {
  const [signals, amplitudes, errors, units] = ["signal", "amplitude", "amplitude_stderr", "unit"].map((name) => table.column(name));
  const rows = Array.from({ length: to - from }, (_, i) => from + i);
  const all = [...new Set(rows.map((row) => signals.text(row)))];
  const signal = all.includes(detail.signal) ? detail.signal : all[0];
  const over = table.column(detail.over);
  const own = rows.filter((row) => signals.text(row) === signal && amplitudes.values[row] > 0);
  const again = (key) => (value) => {
    detail[key] = value;
    showSpectrum(table, from, to, place);
  };
  const host = picture(place, `Spectrum of ${signal}: ${plural(own.length, "line")}`, [
    choice("Signal", all.map((name) => [name, name]), signal, again("signal"), "signal"),
    choice("Over", [["order", "order"], ["frequency", "frequency"]], detail.over, again("over"), "spectrum-over"),
  ]);
  if (own.length === 0) {
    host.append(make("p", { class: "soft" }, "All lines are zero."));
    return;
  }
  const unit = units.text(own[0]) ?? "";
  const range = extent(own.map((row) => amplitudes.values[row]));
  // Lines nine decades below the largest are round-off.
  const low = Math.max(range[0], 1e-9 * range[1]);
  const [factor, name] = scaledUnit(unit, range[1]);
  const [across, acrossUnit] = scaledUnit(over.unit, extent(own.map((row) => over.values[row]))[1]);
  const xs = own.map((row) => over.values[row] * across);
  const ys = own.map((row) => amplitudes.values[row] * factor);
  const [bottom, top] = paddedLog([low * factor, range[1] * factor]);
  const chart = new Chart(host, {
    height: 260,
    x: { label: `${over.name} [${acrossUnit}]`, range: padded(extent(xs)) },
    y: { label: `amplitude [${name}]`, log: true, range: [bottom, top] },
    draw: (pen) => {
      pen.bars(xs, ys.map(() => bottom), ys, themed("accent"), own.length > 400 ? 1 : 2);
      if (own.length <= 400) pen.dots(xs, ys, themed("accent"), 4);
    },
    pick: (left, topPixels, pen) => own[pen.nearest(xs, ys, left, topPixels, 24)] ?? null,
    tip: (row) => [
      `${signal}: ${withError(amplitudes.values[row], errors?.values[row] ?? NaN, unit)}`,
      `order ${digits(table.column("order").values[row])}`,
      withUnit(table.column("frequency").values[row], "Hz"),
    ],
  });
  detail.charts.push(chart);
}
