// Followed orbits: branches with their bifurcations over the followed axis, and bifurcation curves over two axes. Also the
// trajectory of a trace.

const SHAPES = {
  fold: "disc", period_doubling: "square", torus: "triangle", merging: "diamond", branch_point: "plus",
  graze: "cross", jump: "plus", sequence: "cross", end: "bar", onset: "bar",
};

const branches = { what: "branches", y: "deflection_rms", x: "", chart: null, chosen: null };
const trajectory = { y: "deflection", x: "time", chart: null };

/** Columns of numbers of a table, as options of a choice. */
function numberColumns(table) {
  return table.columns.filter((column) => column.kind === "number" || column.kind === "whole").map(({ name }) => [name, name]);
}

/** Values of a column in its shown unit, the factor from SI to this unit, and the label of an axis. */
function shownValues(column, rows) {
  const axis = HEAD.axes?.find((own) => own.name === column.name) ?? column;
  const values = rows.map((row) => column.values[row]);
  const [factor, unit] = plotted(axis, values);
  return { values: values.map((value) => value * factor), factor, label: `${column.name} [${unit}]` };
}

/** All columns of a row that have a value, as lines for the box beside the pointer. */
function rowLines(table, row) {
  return table.columns.filter((column) => column.has(row)).map((column) => `${column.name}: ${valueText(table, column, row)}`);
}

async function startBranches() {
  const table = TABLES.get("branches");
  branches.x = HEAD.axes[HEAD.over].name;
  branches.grid = await Promise.all(HEAD.axes.map((axis) => numbers(axis.values)));
  await Promise.all(["branches", "bifurcations", "curves"].map((name) => TABLES.get(name)?.load()));
  const hasCurves = HEAD.second !== null && (TABLES.get("curves")?.rows ?? 0) > 0;
  const again = (key) => (value) => {
    branches[key] = value;
    controlsOfBranches();
    drawBranches();
  };
  const controlsOfBranches = () => {
    const columns = numberColumns(table);
    const rows = [choice("Column", columns, branches.y, again("y"), "branch-column"), choice("Over", columns, branches.x, again("x"), "branch-over")];
    const kinds = [["branches", "branches"], ["curves", "curves in the plane"]];
    const show = hasCurves ? [choice("Show", kinds, branches.what, again("what"), "branch-what")] : [];
    const focused = document.activeElement?.id;
    document.querySelector("#branches .controls").replaceChildren(...show, ...(branches.what === "curves" ? [] : rows));
    if (focused) document.getElementById(focused)?.focus();
  };
  controlsOfBranches();
  drawBranches();
}

/** Rows of a table, grouped by the value of a column. */
function grouped(table, name) {
  const groups = new Map();
  const column = table.column(name);
  for (let row = 0; row < table.rows; row += 1) {
    const key = column.values[row];
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(row);
  }
  return groups;
}

/** Parts of consecutive rows with equal `key`. Each part also has the first row of the next part, so that lines join. */
function parts(rows, key) {
  const found = [];
  for (const row of rows) {
    const last = found.at(-1);
    if (last !== undefined && last.key === key(row)) last.rows.push(row);
    else {
      last?.rows.push(row);
      found.push({ key: key(row), rows: [row] });
    }
  }
  return found;
}

/** The colour of a kind of bifurcation; kinds without a colour get the text colour of the page. */
function kindColour(name) {
  const colour = HEAD.kinds[name]?.colour;
  return colour === undefined || colour === HEAD.kinds.onset.colour ? themed("ink") : colour;
}

/** Stretches of the curve of an onset of rattle. It is computed at evenly spaced values of the axis that is not the load, and interrupted where no onset exists. */
function stretches(rows, values) {
  const steps = rows.slice(1).map((row, i) => Math.abs(values[row] - values[rows[i]]));
  const most = 1.5 * Math.min(...steps);
  const found = [[]];
  rows.forEach((row, i) => {
    if (i > 0 && steps[i - 1] > most) found.push([]);
    found.at(-1).push(row);
  });
  return found;
}

/** Values at a row of the axes that vary in the table, except the followed axis, as text. */
function otherPlaces(table, row) {
  const others = HEAD.axes.filter((axis, index) => index !== HEAD.over && new Set(table.column(axis.name)?.values).size > 1);
  return others.map((axis) => `${axis.name} ${axisText(axis, table.column(axis.name).values[row])}, `).join("");
}

function drawBranches() {
  const curves = branches.what === "curves";
  const lines = TABLES.get(curves ? "curves" : "branches");
  const marks = curves ? null : TABLES.get("bifurcations");
  const x = curves ? HEAD.axes[HEAD.over].name : branches.x;
  const y = curves ? HEAD.axes[HEAD.second].name : branches.y;
  const all = Array.from({ length: lines.rows }, (_, row) => row);
  const [own, up] = [lines.column(x), lines.column(y)];
  const [xs, ys] = [shownValues(own, all), shownValues(up, all)];
  const marked = marks?.column(x) && marks.column(y) ? Array.from({ length: marks.rows }, (_, row) => row) : [];
  // Marks have the unit of the lines.
  const [mx, my] = [[x, xs], [y, ys]].map(([name, shown]) => marked.map((row) => marks.column(name).values[row] * shown.factor));
  const kind = (curves ? lines : marks)?.column("kind");
  const stable = lines.column("stable");
  const period = lines.column("period");
  const groups = [...grouped(lines, curves ? "curve" : "branch")];
  const colour = (row, index) => (curves ? kindColour(kind.text(row)) : HEAD.palette[index % HEAD.palette.length]);
  const isOnset = (row) => curves && kind.text(row) === "onset";
  const [note, steady] = [lines.column("note"), ["load", "torque"].includes(x) ? ys : xs];
  // An onset may reach far beyond the requested plane, which contains everything else: the range ignores it.
  const range = (shown, axis) => {
    const within = curves ? [...branches.grid[axis]].map((value) => value * shown.factor) : [];
    return padded(extent([...shown.values.filter((value, row) => !isOnset(row)), ...within]));
  };
  const [across, upwards] = [range(xs, HEAD.over), range(ys, HEAD.second)];
  const isWithin = (row) => [[xs, across], [ys, upwards]].every(([shown, [low, high]]) => shown.values[row] >= low && shown.values[row] <= high);
  branches.chart?.remove();
  const host = document.querySelector("#branches .plot");
  host.setAttribute("aria-label", `${lines.name}: ${y} over ${x}. Arrow keys move along a line, or to the next one.`);
  branches.chart = new Chart(host, {
    height: Math.min(560, Math.max(300, innerHeight - 320)),
    x: { label: xs.label, range: across },
    y: { label: ys.label, range: upwards },
    draw: (pen) => {
      groups.forEach(([, rows], index) => {
        const look = (row) => (curves ? (isOnset(row) && note?.text(row) ? "no" : "yes") : stable.text(row));
        const pieces = isOnset(rows[0]) ? stretches(rows, steady.values) : [rows];
        for (const part of pieces.flatMap((piece) => parts(piece, look))) {
          const [a, b] = [xs, ys].map((shown) => part.rows.map((row) => shown.values[row]));
          pen.line(a, b, colour(part.rows[0], index), part.key === "yes" ? { width: 2.2 } : { width: 1.2, dash: [4, 3] });
          if (rows.length === 1) pen.dots(a, b, colour(rows[0], index), 5);
        }
      });
      marked.forEach((row, i) => {
        const fill = kindColour(kind.text(row));
        const own = ["end", "sequence", "jump"].includes(kind.text(row));
        pen.mark(mx[i], my[i], SHAPES[kind.text(row)] ?? "bar", fill, own ? themed("soft") : themed("ink"), own ? 4 : 5);
      });
      const { table, row } = branches.chosen ?? {};
      const [a, b] = table === lines ? [xs.values[row], ys.values[row]] : table === marks ? [mx[row], my[row]] : [NaN, NaN];
      const side = 9 * pen.ratio;
      if (!Number.isNaN(a + b)) frame(pen, pen.x(a) - side, pen.y(b) - side, 2 * side, 2 * side);
    },
    pick: (left, top, pen) => {
      const mark = pen.nearest(mx, my, left, top, 10);
      if (mark >= 0) return { table: marks, row: marked[mark] };
      const line = pen.nearest(xs.values, ys.values, left, top);
      return line >= 0 ? { table: lines, row: line } : null;
    },
    tip: ({ table, row }) => {
      const head = table === marks || curves ? HEAD.kinds[table.column("kind").text(row)]?.name ?? table.column("kind").text(row)
        : `period ${period.values[row]}, ${stable.text(row) === "yes" ? "stable" : "unstable"}`;
      return [head, ...[x, y].map((name) => `${name}: ${valueText(table, table.column(name), row)}`), table.column("detail")?.text(row)].filter((line) => line);
    },
    step: (right, up) => {
      const own = branches.chosen?.table === lines ? branches.chosen.row : -1;
      const at = groups.findIndex(([, rows]) => rows.includes(own));
      if (at < 0) return { table: lines, row: groups[0][1][0] };
      const [, next] = groups[Math.min(Math.max(at + up, 0), groups.length - 1)];
      const place = up === 0 ? next.indexOf(own) + right : 0;
      return { table: lines, row: next[Math.min(Math.max(place, 0), next.length - 1)] };
    },
    choose: (found) => {
      const { table, row } = found;
      branches.chosen = found;
      branches.chart.redraw();
      const columns = table.columns.filter((column) => column.has(row));
      document.getElementById("orbit").replaceChildren(make("h3", {}, `${table.name}, row ${row + 1}`),
        describedTable(columns.map((column) => [column.name, valueText(table, column, row), column.description])));
    },
  });
  const entries = [];
  if (!curves) {
    groups.slice(0, MOST_CURVES).forEach(([number, rows], index) => {
      const periods = [...new Set(rows.map((row) => period.values[row]))];
      entries.push(make("li", {}, swatch(colour(rows[0], index)), `branch ${number}: ${otherPlaces(lines, rows[0])}period ${periods.join(", ")} (${plural(rows.length, "orbit")})`));
    });
    if (groups.length > MOST_CURVES) entries.push(make("li", {}, `and ${count(groups.length - MOST_CURVES)} more`));
    entries.push(make("li", {}, "solid lines: stable; dashed lines: unstable"), make("li", { class: "break", "aria-hidden": "true" }));
  }
  const kinds = new Map();
  for (const row of curves ? groups.map(([, rows]) => rows[0]) : marked) kinds.set(kind.text(row), (kinds.get(kind.text(row)) ?? 0) + 1);
  for (const [name, number] of kinds) {
    const own = kindColour(name);
    const isBeyond = name === "onset" && curves && !all.some((row) => isOnset(row) && isWithin(row));
    entries.push(make("li", {}, curves ? swatch(own) : symbol(SHAPES[name] ?? "bar", own), `${HEAD.kinds[name]?.name ?? name} (${isBeyond ? "beyond" : number})`));
  }
  document.querySelector("#branches .legend").replaceChildren(...entries);
}

/** A symbol of the plot as a character, for the legend. */
function symbol(shape, colour) {
  const texts = { disc: "●", square: "■", triangle: "▲", diamond: "◆", plus: "+", cross: "×", bar: "|" };
  const mark = make("span", { class: "symbol", "aria-hidden": "true" }, texts[shape]);
  if (!["plus", "cross", "bar"].includes(shape)) mark.style.color = colour;
  return mark;
}

/** The metadata of a trace as text: `load 0.1, speed 1047 rad/s · mesh period 300.1 µs · …`. */
function traceWords({ point = "{}", point_units: units = "{}", manifest_hash: hash, ...amounts }) {
  const names = JSON.parse(units);
  const places = Object.entries(JSON.parse(point)).map(([axis, value]) => `${axis} ${joined(digits(value), readable(names[axis] ?? ""))}`);
  const told = ["mesh_period", "half_gap"].filter((key) => amounts[key]).map((key) => {
    const { value, unit } = JSON.parse(amounts[key]);
    return `${key.replace("_", " ")} ${withUnit(value, unit)}`;
  });
  return [places.join(", "), ...told, hash ? `manifest ${hash}` : ""].filter((words) => words).join(" · ");
}

async function startTrajectory() {
  const table = TABLES.get("trace");
  await table.load();
  const again = (key) => (value) => {
    trajectory[key] = value;
    drawTrajectory(table);
  };
  document.querySelector("#trajectory .controls").replaceChildren(
    choice("Signal", numberColumns(table), trajectory.y, again("y"), "trace-signal"),
    choice("Over", numberColumns(table), trajectory.x, again("x"), "trace-over"));
  document.querySelector("#trajectory .caption").textContent = traceWords(HEAD.trace ?? {});
  drawTrajectory(table);
}

function drawTrajectory(table) {
  const all = Array.from({ length: table.rows }, (_, row) => row);
  const [xs, ys] = [trajectory.x, trajectory.y].map((name) => shownValues(table.column(name), all));
  trajectory.chart?.remove();
  const host = document.querySelector("#trajectory .plot");
  host.setAttribute("aria-label", `${trajectory.y} over ${trajectory.x}`);
  trajectory.chart = new Chart(host, {
    height: Math.min(520, Math.max(300, innerHeight - 300)),
    x: { label: xs.label, range: padded(extent(xs.values), 0.01) },
    y: { label: ys.label, range: padded(extent(ys.values)) },
    draw: (pen) => pen.line(xs.values, ys.values, themed("accent"), { width: 1.2 }),
    pick: (left, top, pen) => {
      const row = pen.nearest(xs.values, ys.values, left, top);
      return row >= 0 ? row : null;
    },
    tip: (row) => rowLines(table, row).slice(0, 10),
  });
}
