// A column as a map over two axes, or as curves over one, for points with equal values on all other axes.

/** Smallest filled part of a map. With fewer points, each point is a mark at its values. */
const FILLED = 0.2;
/** Largest number of cells of a map, and of curves of a plot. */
const MOST_CELLS = 1 << 23;
const MOST_CURVES = 24;

const map = { column: "lambda_max", x: 0, y: -1, log: false, curves: false, direction: "", held: new Map(), chart: null, asked: 0 };

/** Starts the view: with a map over the axes that the page names for maps, else with curves over the axis with most values. */
async function startMap() {
  const varied = variedAxes();
  map.column = ["lambda_max", "deflection_rms"].find((name) => POINTS.column(name) !== null) ?? "class";
  const longest = varied.reduce((a, b) => (grid.axes[b].values.length >= (grid.axes[a]?.values.length ?? 0) ? b : a), varied[0] ?? 0);
  const along = grid.axes.findIndex((axis) => axis.name === HEAD.along);
  if (HEAD.spanning.length >= 2) [map.y, map.x] = HEAD.spanning;
  else [map.x, map.y, map.curves] = [along >= 0 ? along : longest, -1, true];
  map.direction = grid.directions?.values.includes("up") ? "up" : grid.directions?.values[0] ?? "";
  grid.listeners.push(() => map.chart?.redraw());
  controls();
  await drawMap();
}

/** Axes with several values that are fixed in the picture. */
function heldAxes() {
  const second = map.y < 0 ? map.x : map.y;
  return HEAD.held[map.x]?.[second]?.filter((axis) => grid.axes[axis].values.length > 1) ?? [];
}

/** The fixed values of the picture as text: `, load 0.1, sweep up`. */
function heldWords() {
  const words = heldAxes().map((index) => {
    const axis = grid.axes[index];
    return `, ${axis.name} ${axisText(axis, axis.values[map.held.get(index) ?? axis.rank[0]])}`;
  });
  const swept = grid.directions?.values.length > 1 && !map.curves && map.y >= 0;
  return words.join("") + (swept ? `, sweep ${map.direction}` : "");
}

/** Axes other than those of the picture on which its points differ: axes tied to an axis of the picture. None for a picture over the swept axis, because the points of a chain form one line. */
function accompanying() {
  if (grid.axes[map.x].name === HEAD.along) return [];
  const told = [map.x, map.y, ...heldAxes()];
  return variedAxes().filter((axis) => !told.includes(axis));
}

function controls() {
  const varied = variedAxes();
  const section = document.getElementById("map");
  const names = varied.map((axis) => [String(axis), grid.axes[axis].name]);
  const change = (key, read = (value) => value) => (value) => {
    map[key] = read(value);
    controls();
    // The side beside the map shows the value of the same column.
    drawMap().then(() => selectPoint(grid.selected));
  };
  const rows = [choice("Column", shownColumns(), map.column, change("column"), "column")];
  if (varied.length > 1) {
    rows.push(choice("As", [["map", "map"], ["curves", "curves"]], map.curves ? "curves" : "map", (value) => {
      map.curves = value === "curves";
      if (map.y < 0) map.y = varied.find((axis) => axis !== map.x);
      controls();
      drawMap();
    }, "kind"));
    const other = (key, from) => (value) => {
      if (map[key] === Number(value)) map[key] = map[from];
      map[from] = Number(value);
      controls();
      drawMap();
    };
    rows.push(choice(map.curves ? "Over" : "Across", names, String(map.x), other("y", "x"), "across"));
    const up = map.curves ? [["-1", "one curve"], ...names] : names;
    rows.push(choice(map.curves ? "Curves by" : "Up", up, String(map.y), other("x", "y"), "up"));
  }
  for (const index of heldAxes()) {
    const axis = grid.axes[index];
    const options = Array.from(axis.values, (value, place) => [String(place), axisText(axis, value)]);
    const own = map.held.get(index) ?? axis.rank[0];
    rows.push(choice(axis.name, options, String(own), (value) => {
      map.held.set(index, Number(value));
      drawMap();
    }, `held-${index}`));
  }
  const directions = grid.directions?.values ?? [];
  if (directions.length > 1 && !map.curves) {
    rows.push(choice("Sweep", directions.map((word) => [word, word]), map.direction, change("direction"), "direction"));
  }
  if (POINTS.column(map.column.split("#")[0]).kind !== "text") rows.push(tick("logarithmic", map.log, change("log"), "log"));
  const bar = section.querySelector(".controls");
  const focused = document.activeElement?.id;
  bar.replaceChildren(...rows);
  if (focused) document.getElementById(focused)?.focus();
}

/** Rows of the points with the fixed values; for a map, only those of one direction of the sweep. */
function slice() {
  const held = heldAxes().map((index) => [grid.axes[index].rank, map.held.get(index) ?? grid.axes[index].rank[0]]);
  const rows = [];
  for (let row = 0; row < POINTS.rows; row += 1) {
    const onSlice = held.every(([rank, place]) => rank[row] === place);
    const swept = map.curves || !grid.directions || grid.directions.text(row) === map.direction;
    if (onSlice && swept) rows.push(row);
  }
  return rows;
}

async function drawMap() {
  map.asked += 1;
  const asked = map.asked;
  const shown = await shownColumn(map.column);
  await POINTS.load("errors_verified");
  if (map.curves || map.y < 0) await shown.loadErrors();
  // The user may have requested another picture meanwhile.
  if (asked !== map.asked) return;
  const rows = slice();
  const host = document.querySelector("#map .plot");
  map.chart?.remove();
  const colours = colouring(shown, rows);
  const [x, y] = [grid.axes[map.x], grid.axes[map.y]];
  let spec;
  if (map.curves || y === undefined) {
    spec = curves(shown, rows);
  } else {
    const planes = HEAD.plane?.axes.includes(x.name) && HEAD.plane.axes.includes(y.name);
    const cells = x.values.length * y.values.length;
    const isMap = planes || (cells <= MOST_CELLS && rows.length >= FILLED * cells);
    spec = isMap ? heat(shown, rows, colours) : scatter(shown, rows, colours);
  }
  map.chart = new Chart(host, { height: Math.min(520, Math.max(300, innerHeight - 330)), ...spec, choose: selectPoint });
  legend(shown, colours, rows);
  const words = `${shown.title}${spec.words}${heldWords()}. ${plural(rows.length, "point")}. Arrow keys move the selected point.`;
  host.setAttribute("aria-label", words);
  document.querySelector("#map .caption").textContent =
    `${shown.title}${shown.unit === "" || shown.unit === "1" ? "" : ` [${readable(shown.unit)}]`}: ${shown.description}`;
}

/** A function for the colour of a row, `[r, g, b]`, with the data of the legend. */
function colouring(shown, rows) {
  if (shown.isMotion) {
    const all = HEAD.motions.map((motion) => rgb(motion.colour));
    return { of: (row) => all[grid.motion[row]] };
  }
  if (shown.isText) {
    const names = [...new Set(rows.map((row) => shown.text(row)))].sort();
    const colour = new Map(names.map((name, place) => [name, HEAD.palette[place % HEAD.palette.length]]));
    return { names, colour, of: (row) => rgb(colour.get(shown.text(row))) };
  }
  const range = extent(rows.map(shown.number), map.log);
  const [low, high] = range ?? [0, 1];
  const scale = map.log ? Math.log : (value) => value;
  const part = (value) => (high > low ? (scale(value) - scale(low)) / (scale(high) - scale(low)) : 0.5);
  const steps = Array.from({ length: 256 }, (_, step) => rampColour(step / 255));
  return {
    range,
    of: (row) => {
      const place = part(shown.number(row));
      return Number.isFinite(place) ? steps[Math.round(255 * Math.min(Math.max(place, 0), 1))] : null;
    },
  };
}

/** The row of the point in each cell; −1 for an empty cell. */
function cellsOf(rows, x, y) {
  const [across, up] = [x.values.length, y.values.length];
  const cells = new Int32Array(across * up).fill(-1);
  if (grid.stands && HEAD.plane.axes.includes(x.name) && HEAD.plane.axes.includes(y.name)) {
    const straight = HEAD.plane.axes[0] === y.name;
    for (let row = 0; row < up; row += 1) {
      for (let column = 0; column < across; column += 1) {
        cells[row * across + column] = grid.stands[straight ? row * across + column : column * up + row] - 1;
      }
    }
    return cells;
  }
  for (const row of rows) cells[y.rank[row] * across + x.rank[row]] = row;
  return cells;
}

/** Ticks of an axis of cells: the value of every n-th cell, so that the texts have room. */
function cellTicks(axis, room) {
  return {
    ticks: (low, high, length) => {
      const [first, last] = [Math.max(0, Math.ceil(low)), Math.min(axis.values.length - 1, Math.floor(high))];
      const step = Math.max(1, Math.ceil(((last - first + 1) * room) / length));
      const places = [];
      for (let place = first; place <= last; place += step) places.push(place);
      return places;
    },
    text: (place) => (Number.isInteger(place) ? digits(axis.values[place] * axis.factor) : ""),
  };
}

function heat(shown, rows, colours) {
  const [x, y] = [grid.axes[map.x], grid.axes[map.y]];
  const [across, up] = [x.values.length, y.values.length];
  const cells = cellsOf(rows, x, y);
  const picture = new OffscreenCanvas(across, up);
  const image = new ImageData(across, up);
  const pixels = new Uint32Array(image.data.buffer);
  const paint = () => {
    const none = rgb(themed("none"));
    for (let row = 0; row < up; row += 1) {
      for (let column = 0; column < across; column += 1) {
        const own = cells[row * across + column];
        if (own < 0) continue;
        const [red, green, blue] = colours.of(own) ?? none;
        pixels[(up - 1 - row) * across + column] = (255 << 24) | (blue << 16) | (green << 8) | red;
      }
    }
    picture.getContext("2d").putImageData(image, 0, 0);
  };
  paint();
  const mask = hatchedCells(cells, across, up);
  let theme = document.documentElement.dataset.theme;
  const at = (column, row) => (column >= 0 && column < across && row >= 0 && row < up ? cells[row * across + column] : -1);
  return {
    asCells: true,
    words: ` over ${x.name} and ${y.name}`,
    x: { label: axisLabel(x), range: [-0.5, across - 0.5], ...cellTicks(x, 56) },
    y: { label: axisLabel(y), range: [-0.5, up - 0.5], ...cellTicks(y, 22) },
    draw: (pen) => {
      if (theme !== document.documentElement.dataset.theme) {
        theme = document.documentElement.dataset.theme;
        paint();
      }
      const [left, top] = [pen.x(-0.5), pen.y(up - 0.5)];
      const [right, bottom] = [pen.x(across - 0.5), pen.y(-0.5)];
      pen.ctx.imageSmoothingEnabled = false;
      pen.ctx.drawImage(picture, left, top, right - left, bottom - top);
      const [width, height] = [(right - left) / across, (bottom - top) / up];
      if (mask !== null) hatch(pen, mask, left, top, right - left, bottom - top);
      const hasRoom = Math.min(width, height) > LETTERED * pen.ratio;
      if (hasRoom) letters(pen, shown.isMotion ? rows : rows.filter(isOpen), x, y, colours);
      if (shown.name === "lambda_max" && hasRoom) dots(pen, rows, x, y, width, height);
      if (grid.selected >= 0 && rows.includes(grid.selected)) {
        const [a, b] = [pen.x(x.rank[grid.selected]), pen.y(y.rank[grid.selected])];
        // The frame has a smallest size, so that a cell of one or two pixels is visible in it.
        const [wide, high] = [width, height].map((side) => Math.max(side, 12 * pen.ratio));
        frame(pen, a - wide / 2, b - high / 2, wide, high);
      }
    },
    pick: (left, top, pen) => {
      const row = at(Math.round(pen.plot.posToVal(left, "x")), Math.round(pen.plot.posToVal(top, "y")));
      return row >= 0 ? row : null;
    },
    tip: (row) => pointLines(row, shown),
    step: (right, upwards) => {
      if (grid.selected < 0) return rows[0];
      let [column, row] = [x.rank[grid.selected], y.rank[grid.selected]];
      for (;;) {
        [column, row] = [column + right, row + upwards];
        if (column < 0 || column >= across || row < 0 || row >= up) return grid.selected;
        const found = at(column, row);
        if (found >= 0 && found !== grid.selected) return found;
      }
    },
  };
}

/** The hatched cells of a map, as a picture with one pixel per cell; null if there are none. */
function hatchedCells(cells, across, up) {
  const mask = new ImageData(across, up);
  const pixels = new Uint32Array(mask.data.buffer);
  let found = false;
  for (let row = 0; row < up; row += 1) {
    for (let column = 0; column < across; column += 1) {
      const own = cells[row * across + column];
      if (own < 0 || !isHatched(own)) continue;
      pixels[(up - 1 - row) * across + column] = 0xff000000;
      found = true;
    }
  }
  if (!found) return null;
  const picture = new OffscreenCanvas(across, up);
  picture.getContext("2d").putImageData(mask, 0, 0);
  return picture;
}

/** A tile of diagonal lines. Each has a dark and a light side, so that it is visible on every colour. */
function hatching(ratio) {
  const side = Math.round(8 * ratio);
  const tile = new OffscreenCanvas(side, side);
  const ctx = tile.getContext("2d");
  ctx.lineWidth = ratio;
  for (const [colour, aside] of [["rgb(0 0 0 / 70%)", 0], ["rgb(255 255 255 / 70%)", 1.4 * ratio]]) {
    ctx.strokeStyle = colour;
    ctx.beginPath();
    for (const sum of [0, side, 2 * side]) {
      ctx.moveTo(-side, sum + side + aside);
      ctx.lineTo(2 * side, sum - 2 * side + aside);
    }
    ctx.stroke();
  }
  return tile;
}

/** Hatches the cells of a mask, which covers the same rectangle as the map. */
function hatch(pen, mask, left, top, width, height) {
  const { canvas } = pen.ctx;
  const layer = new OffscreenCanvas(canvas.width, canvas.height);
  const ctx = layer.getContext("2d");
  ctx.imageSmoothingEnabled = false;
  ctx.drawImage(mask, left, top, width, height);
  ctx.globalCompositeOperation = "source-in";
  ctx.fillStyle = ctx.createPattern(hatching(pen.ratio), "repeat");
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  pen.ctx.drawImage(layer, 0, 0);
}

/** Dots in the corners of cells whose standard errors are not verified. */
function dots(pen, rows, x, y, width, height) {
  const { ctx, ratio } = pen;
  for (const row of rows.filter(isUnverified)) {
    const [left, top] = [pen.x(x.rank[row]) + width / 2 - 5 * ratio, pen.y(y.rank[row]) - height / 2 + 5 * ratio];
    for (const [colour, radius] of [["#ffffff", 2.6], ["#222222", 1.8]]) {
      ctx.fillStyle = colour;
      ctx.beginPath();
      ctx.arc(left, top, radius * ratio, 0, 2 * Math.PI);
      ctx.fill();
    }
  }
}

/** Smallest side of a cell with a letter or a dot, in pixels of the page. */
const LETTERED = 14;

/** Draws the marks of motions in their cells. */
function letters(pen, rows, x, y, colours) {
  const { ctx } = pen;
  ctx.font = `${11 * pen.ratio}px system-ui, sans-serif`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  for (const row of rows) {
    const [r, g, b] = colours.of(row) ?? rgb(themed("none"));
    if (isHatched(row)) {
      // Lines behind letters make them hard to read.
      const half = 7 * pen.ratio;
      ctx.fillStyle = `rgb(${r},${g},${b})`;
      ctx.fillRect(pen.x(x.rank[row]) - half, pen.y(y.rank[row]) - half, 2 * half, 2 * half);
    }
    ctx.fillStyle = 0.299 * r + 0.587 * g + 0.114 * b > 140 ? "#222222" : "#ffffff";
    ctx.fillText(HEAD.motions[grid.motion[row]].mark, pen.x(x.rank[row]), pen.y(y.rank[row]));
  }
}

/** A frame in two colours, visible on every background. */
function frame(pen, left, top, width, height) {
  const { ctx, ratio } = pen;
  for (const [colour, line] of [["#ffffff", 4], ["#d00000", 2]]) {
    ctx.strokeStyle = colour;
    ctx.lineWidth = line * ratio;
    ctx.strokeRect(left, top, width, height);
  }
}

/** Marks at the values of two axes. */
function scatter(shown, rows, colours) {
  const [x, y] = [grid.axes[map.x], grid.axes[map.y]];
  const [xs, ys] = [x, y].map((axis) => rows.map((row) => axis.column[row] * axis.factor));
  return {
    words: ` at ${x.name} and ${y.name}`,
    x: { label: axisLabel(x), range: padded(extent(xs)) },
    y: { label: axisLabel(y), range: padded(extent(ys)) },
    draw: (pen) => {
      const none = rgb(themed("none"));
      rows.forEach((row, i) => {
        const colour = `rgb(${(colours.of(row) ?? none).join()})`;
        if (rows.length > 2000) pen.dots([xs[i]], [ys[i]], colour, 3);
        else pen.mark(xs[i], ys[i], "disc", colour, themed("ink"), 5);
        if (isHatched(row) || isOpen(row)) pen.dots([xs[i]], [ys[i]], HEAD.motions[grid.motion[row]].colour, 4);
      });
      const own = rows.indexOf(grid.selected);
      if (own >= 0) frame(pen, pen.x(xs[own]) - 9 * pen.ratio, pen.y(ys[own]) - 9 * pen.ratio, 18 * pen.ratio, 18 * pen.ratio);
    },
    pick: (left, top, pen) => rows[pen.nearest(xs, ys, left, top)] ?? null,
    tip: (row) => pointLines(row, shown),
    step: (right, up) => rows[(rows.indexOf(grid.selected) + right + up + rows.length) % rows.length],
  };
}

/** The curves: groups of rows in ascending order of the horizontal axis. Sweeps up and down are separate curves. */
function curvesOf(rows) {
  const [x, by] = [grid.axes[map.x], grid.axes[map.y]];
  const groups = new Map();
  for (const row of rows) {
    const place = by === undefined ? 0 : by.rank[row];
    const direction = grid.directions?.text(row) ?? "";
    const key = `${place}/${direction}`;
    if (!groups.has(key)) groups.set(key, { place, direction, rows: [] });
    groups.get(key).rows.push(row);
  }
  const all = [...groups.values()].sort((a, b) => a.place - b.place || (a.direction < b.direction ? 1 : -1));
  all.forEach((group) => group.rows.sort((a, b) => x.rank[a] - x.rank[b]));
  return all;
}

/** Lists of positions in a curve whose points a line joins: they differ only on the horizontal axis. */
function joinedPlaces(rows) {
  const others = accompanying();
  const parts = new Map();
  rows.forEach((row, place) => {
    const key = others.map((axis) => grid.axes[axis].rank[row]).join();
    if (!parts.has(key)) parts.set(key, []);
    parts.get(key).push(place);
  });
  return [...parts.values()].filter((places) => places.length > 1);
}

function curves(shown, rows) {
  const [x, by] = [grid.axes[map.x], grid.axes[map.y]];
  const groups = curvesOf(rows);
  const step = Math.ceil(groups.length / MOST_CURVES);
  // If curves are left out, the remaining ones keep all their directions.
  const places = [...new Set(groups.map((group) => group.place))].filter((place, index) => index % step === 0);
  const drawn = groups.filter((group) => places.includes(group.place));
  const kinds = [...new Set(rows.map((row) => (shown.isMotion ? grid.motion[row] : shown.isText ? shown.text(row) : 0)))].sort((a, b) => (a < b ? -1 : 1));
  const value = (row) => {
    if (shown.isMotion) return kinds.indexOf(grid.motion[row]);
    if (shown.isText) return kinds.indexOf(shown.text(row));
    const own = shown.number(row);
    return map.log && !(own > 0) ? NaN : own;
  };
  const all = drawn.flatMap((group) => group.rows);
  const ends = all.flatMap((row) => [value(row) - (shown.error(row) || 0), value(row) + (shown.error(row) || 0)]);
  const range = extent(ends, map.log && !shown.isText);
  const [factor, unit] = shown.isText ? [1, ""] : scaledUnit(shown.unit, Math.max(...(range ?? [1]).map(Math.abs)));
  const scaled = (range ?? [0, 1]).map((end) => end * factor);
  for (const group of drawn) {
    // If curves differ only in the direction of the sweep, each direction has its own colour.
    const index = places.length > 1 ? places.indexOf(group.place) : drawn.indexOf(group);
    const ordered = places.length > HEAD.palette.length;
    // The end of the ramp that resembles the background is not used.
    const part = index / (places.length - 1);
    const seen = document.documentElement.dataset.theme === "dark" ? 0.25 + 0.75 * part : 0.92 * part;
    group.colour = ordered ? `rgb(${rampColour(seen).join()})` : HEAD.palette[index];
    group.xs = group.rows.map((row) => x.column[row] * x.factor);
    group.ys = group.rows.map((row) => value(row) * factor);
    group.joined = shown.isText ? [] : joinedPlaces(group.rows);
    const end = (sign) => group.rows.map((row) => (value(row) + sign * shown.error(row)) * factor);
    [group.lows, group.highs] = [end(-1).map((low) => (map.log && low <= 0 ? scaled[0] : low)), end(1)];
    group.name = [by && by !== x ? `${by.name} ${axisText(by, by.values[group.place])}` : "", group.direction && `sweep ${group.direction}`]
      .filter((word) => word).join(", ");
  }
  map.groups = { drawn, left: groups.length - drawn.length, by };
  const xs = drawn.flatMap((group) => group.xs);
  const ys = drawn.flatMap((group) => group.ys);
  const log = map.log && !shown.isText;
  const steps = shown.isText && {
    range: [-0.5, kinds.length - 0.5],
    size: 120,
    ticks: () => kinds.map((kind, place) => place),
    text: (place) => (shown.isMotion ? HEAD.motions[kinds[place]].name : kinds[place]) ?? "",
  };
  return {
    words: ` over ${x.name}`,
    x: { label: axisLabel(x), range: padded(extent(xs)) },
    y: { label: shown.isText ? shown.title : `${shown.title} [${unit}]`, log, range: log ? paddedLog(scaled) : padded(scaled), ...steps },
    draw: (pen) => {
      for (const group of drawn) {
        const dash = isBroken(group) ? [6, 4] : [];
        for (const places of group.joined) pen.line(places.map((at) => group.xs[at]), places.map((at) => group.ys[at]), group.colour, { dash });
        pen.bars(group.xs, group.lows, group.highs, group.colour);
        if (group.rows.length > 2000) pen.dots(group.xs, group.ys, group.colour, 2);
        else group.rows.forEach((row, i) => pen.mark(group.xs[i], group.ys[i], "disc", HEAD.motions[grid.motion[row]].colour, group.colour, 4));
      }
      const own = all.indexOf(grid.selected);
      if (own >= 0) frame(pen, pen.x(xs[own]) - 9 * pen.ratio, pen.y(ys[own]) - 9 * pen.ratio, 18 * pen.ratio, 18 * pen.ratio);
    },
    pick: (left, top, pen) => all[pen.nearest(xs, ys, left, top)] ?? null,
    tip: (row) => pointLines(row, shown),
    step: (right, up) => {
      const own = drawn.findIndex((group) => group.rows.includes(grid.selected));
      if (own < 0) return all[0];
      const place = drawn[own].rows.indexOf(grid.selected);
      if (up === 0) return drawn[own].rows[Math.min(Math.max(place + right, 0), drawn[own].rows.length - 1)];
      const next = drawn[Math.min(Math.max(own + up, 0), drawn.length - 1)];
      const rank = x.rank[grid.selected];
      return next.rows.find((row) => x.rank[row] >= rank) ?? next.rows.at(-1);
    },
  };
}

/** Whether the line of a curve is dashed: that of a sweep down is. */
function isBroken(group) {
  return group.direction === "down";
}

/** Draws the legend below the picture. */
function legend(shown, colours, rows) {
  const entries = [];
  const entry = (colour, text, hatched = false) => entries.push(make("li", {}, swatch(colour, hatched), text));
  const { asCells } = map.chart.spec;
  const asCurves = map.curves || map.y < 0;
  if (asCurves) {
    const { drawn, left } = map.groups;
    if (drawn.length > 1) drawn.forEach((group) => entries.push(make("li", {}, shown.isText ? swatch(group.colour) : stroke(group.colour, isBroken(group)), group.name)));
    const others = accompanying().map((axis) => grid.axes[axis].name);
    if (others.length > 0) {
      const joins = drawn.some((group) => group.joined.length > 0);
      entries.push(make("li", { class: "joins" }, joins ? `lines join points with the same ${others.join(", ")}` : `points also differ in ${others.join(", ")}`));
    }
    if (left > 0) entries.push(make("li", {}, `and ${plural(left, "curve")} in between, not drawn`));
    entries.push(make("li", { class: "break", "aria-hidden": "true" }));
  }
  if (shown.isMotion || asCurves) {
    const counts = new Map();
    for (const row of rows) counts.set(grid.motion[row], (counts.get(grid.motion[row]) ?? 0) + 1);
    [...counts].sort(([a], [b]) => a - b).forEach(([motion, number]) => {
      const { name, mark, colour, hatched } = HEAD.motions[motion];
      entry(colour, `${asCurves ? "" : `${mark}  `}${name} (${count(number)})`, hatched && !asCurves);
    });
  } else if (shown.isText) {
    colours.names.forEach((name) => entry(colours.colour.get(name), name));
  } else if (colours.range) {
    const [low, high] = colours.range;
    const middle = map.log ? Math.sqrt(low * high) : (low + high) / 2;
    const bar = make("span", { class: "ramp", "aria-hidden": "true" });
    bar.style.background = `linear-gradient(to right, ${HEAD.ramp.join()})`;
    const [factor, unit] = scaledUnit(shown.unit, Math.max(Math.abs(low), Math.abs(high)));
    const text = (value) => make("span", {}, digits(value * factor));
    const scale = make("span", { class: "scale" }, bar, make("span", { class: "ends" }, text(low), text(middle), text(high)));
    entries.push(make("li", {}, scale, unit === "–" ? "" : unit));
    if (rows.some((row) => colours.of(row) === null)) entry("var(--none)", "no value");
  }
  if (!shown.isMotion && !asCurves) {
    HEAD.motions.forEach(({ name, mark, colour, hatched }, motion) => {
      const found = hatched || mark === OPEN ? rows.filter((row) => grid.motion[row] === motion).length : 0;
      if (found === 0) return;
      if (asCells) entry("transparent", `${hatched ? "" : `${mark}  `}${name} (${count(found)})`, hatched);
      else entry(colour, `${name} (${count(found)})`);
    });
  }
  const unverified = shown.name === "lambda_max" || asCurves ? rows.filter(isUnverified).length : 0;
  if (unverified > 0 && !shown.isText) {
    const dot = asCurves ? null : make("span", { class: "swatch dotted", "aria-hidden": "true" });
    entries.push(make("li", { class: "unverified" }, dot, `standard errors not verified (${count(unverified)})`));
  }
  document.querySelector("#map .legend").replaceChildren(...entries);
}
