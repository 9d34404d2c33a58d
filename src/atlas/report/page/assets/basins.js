// Basins of attraction: a slice of initial states of a point, each cell in the colour of the attractor to which it leads.

function showBasins(table, from, to, place) {
  const [i, j, x, y, attractors, statuses] = ["i", "j", "x", "y", "attractor_id", "status"].map((name) => table.column(name));
  const rows = Array.from({ length: to - from }, (_, row) => from + row);
  const host = picture(place, `Basins of attraction: ${plural(rows.length, "cell")}`, []);
  const [across, up] = [x, y].map((column, side) => {
    const [name, unit] = HEAD.slice[side];
    const values = rows.map((row) => column.values[row]);
    const range = extent(values) ?? [0, 1];
    const [factor, shown] = scaledUnit(unit, Math.max(...range.map(Math.abs)));
    return { range: range.map((end) => end * factor), label: `${name} [${shown}]`, told: (row) => `${name}: ${withUnit(column.values[row], unit)}` };
  });
  const cells = new Map(rows.map((row) => [`${i.values[row]} ${j.values[row]}`, row]));
  const sides = [i, j].map((column) => 1 + (extent(rows.map((row) => column.values[row]))?.[1] ?? 0));
  const half = [across, up].map(({ range }, side) => (range[1] - range[0]) / Math.max(1, sides[side] - 1) / 2 || 0.5);
  const id = (row) => attractors?.values[row] ?? NaN;
  const colour = (row) => (Number.isNaN(id(row)) ? themed("none") : HEAD.palette[id(row) % HEAD.palette.length]);
  const ending = (row) => (Number.isNaN(id(row)) ? `no attractor: ${statuses.text(row).replaceAll("_", " ")}` : `attractor ${id(row)}`);
  const chart = new Chart(host, {
    height: 300,
    x: { label: across.label, range: [across.range[0] - half[0], across.range[1] + half[0]] },
    y: { label: up.label, range: [up.range[0] - half[1], up.range[1] + half[1]] },
    draw: (pen) => rows.forEach((row) => {
      pen.ctx.fillStyle = colour(row);
      const edge = (cell, side) => [across, up][side].range[0] + (2 * cell - 1) * half[side];
      // Cells end on whole pixels. Otherwise abutting edges would show as seams.
      const [left, right] = [0, 1].map((more) => Math.round(pen.x(edge(i.values[row] + more, 0))));
      const [bottom, top] = [0, 1].map((more) => Math.round(pen.y(edge(j.values[row] + more, 1))));
      pen.ctx.fillRect(left, top, right - left, bottom - top);
    }),
    pick: (left, top, pen) => {
      const at = [pen.plot.posToVal(left, "x"), pen.plot.posToVal(top, "y")];
      const [column, row] = at.map((value, side) => Math.round((value - [across, up][side].range[0]) / (2 * half[side])));
      return cells.get(`${column} ${row}`) ?? null;
    },
    tip: (row) => [
      ending(row),
      across.told(row), up.told(row),
    ],
  });
  detail.charts.push(chart);
  const found = new Map(rows.map((row) => [ending(row), row]));
  chart.save.after(make("ul", { class: "legend" }, [...found.keys()].sort((a, b) => a.localeCompare(b, "en", { numeric: true })).map((text) => make("li", {}, swatch(colour(found.get(text))), text))));
}
