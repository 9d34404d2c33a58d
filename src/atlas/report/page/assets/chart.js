// A plot over two axes. uPlot draws the axes and the grid, and zooms (drag; a double click shows all again). This code draws
// the contents, and finds the element at the pointer.

const CHARTS = new Set();

/** A colour of the page's theme. */
function themed(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Ticks of a logarithmic axis: 1, 2 and 5 times powers of ten, or as many powers of ten as there is room for. */
function decades(low, high, room) {
  const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
  const wide = Math.log10(high / low);
  const mantissas = wide < 2.2 ? [1, 2, 5] : [1];
  const step = Math.max(1, Math.ceil(wide / room));
  const ticks = [];
  for (let exponent = first; exponent <= last; exponent += 1) {
    for (const mantissa of exponent % step === 0 ? mantissas : []) {
      const value = Number(`${mantissa}e${exponent}`);
      if (value >= low && value <= high) ticks.push(value);
    }
  }
  return ticks;
}

class Chart {
  /**
   * `spec.x`, `spec.y`: `label`, `range` and, optionally, `log`, `size` of the texts, `ticks(low, high, room)` and `text(value)`.
   * `draw(pen)` draws the contents. `pick(x, y, pen)` finds the element at a place in pixels of the page; `tip(found)` describes
   * it in lines, and a click calls `choose(found)`. `step(right, up)` finds the element to which an arrow key moves.
   */
  constructor(host, spec) {
    this.host = host;
    this.spec = spec;
    CHARTS.add(this);
    this.save = make("button", { type: "button", class: "save", onclick: () => savePicture(this) }, "Save picture");
    host.after(this.save);
    host.onkeydown = spec.step ? (event) => this.key(event) : null;
    this.build();
    this.sizes = new ResizeObserver(() => this.fit());
    this.sizes.observe(host);
  }

  get height() {
    return this.spec.height ?? 320;
  }

  build() {
    const { x, y } = this.spec;
    const font = "12px system-ui, sans-serif";
    const axis = (side, own, size) => ({
      side,
      label: own.label,
      labelFont: font,
      labelSize: 18,
      font,
      size,
      space: side === 2 ? 70 : 34,
      stroke: themed("ink"),
      grid: { stroke: themed("faint"), width: 1, show: own.ticks === undefined },
      ticks: { stroke: themed("faint"), width: 1 },
      // The logarithmic ticks of the library assume that an axis begins at a power of ten.
      splits: (own.ticks ?? own.log) && ((u, index, low, high) => {
        const length = u.bbox[side === 2 ? "width" : "height"] / devicePixelRatio;
        return own.ticks ? own.ticks(low, high, length) : decades(low, high, length / (side === 2 ? 70 : 34));
      }),
      filter: (u, ticks) => ticks,
      values: (u, ticks) => ticks.map((value) => (value === null ? "" : own.text ? own.text(value) : digits(value))),
    });
    const scale = (own) => ({
      time: false,
      distr: own.log ? 3 : 1,
      range: (u, low, high) => (own === x && low !== null && low !== high ? [low, high] : own.range),
    });
    const options = {
      width: Math.max(this.host.clientWidth, 200),
      height: this.height,
      legend: { show: false },
      cursor: { x: false, y: false, points: { show: false }, drag: { x: true, y: true, dist: 8 } },
      scales: { x: scale(x), y: scale(y) },
      axes: [axis(2, x, 34), axis(3, y, y.size ?? 64)],
      series: [{}, { paths: () => null, points: { show: false } }],
      hooks: { draw: [(u) => this.draw(u)] },
    };
    this.plot = new uPlot(options, [x.range, y.range], this.host);
    const over = this.plot.over;
    over.addEventListener("pointermove", (event) => this.point(event));
    over.addEventListener("pointerleave", () => tip.hide());
    over.addEventListener("click", (event) => {
      const found = this.found(event);
      if (found !== null) this.spec.choose?.(found);
    });
  }

  draw(u) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    this.spec.draw(new Pen(u));
    ctx.restore();
  }

  found(event) {
    const area = this.plot.over.getBoundingClientRect();
    return this.spec.pick?.(event.clientX - area.left, event.clientY - area.top, new Pen(this.plot)) ?? null;
  }

  point(event) {
    const found = event.buttons === 0 ? this.found(event) : null;
    if (found === null) tip.hide();
    else tip.show(event, this.spec.tip(found));
    this.plot.over.style.cursor = found !== null && this.spec.choose ? "pointer" : "crosshair";
  }

  key(event) {
    const move = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (move === undefined) return;
    event.preventDefault();
    this.spec.choose(this.spec.step(...move));
  }

  /** Draws the contents again, without the axes. */
  redraw() {
    this.plot.redraw(false);
  }

  fit() {
    const width = this.host.clientWidth;
    if (width > 0 && width !== this.plot.width) this.plot.setSize({ width, height: this.height });
  }

  /** Draws everything again, in the colours of another theme. */
  rebuild() {
    this.plot.destroy();
    this.build();
  }

  remove() {
    this.sizes.disconnect();
    this.plot.destroy();
    this.save.remove();
    CHARTS.delete(this);
  }
}

/**
 * Saves a chart as shown, with its name, its legend and its caption. The browser draws the texts as part of an SVG image,
 * in which the styles of the page apply. If a browser does not allow reading such an image, only the plot is saved.
 */
async function savePicture({ host, plot }) {
  const name = `${HEAD.job ?? HEAD.folder}: ${host.getAttribute("aria-label").split(". ")[0]}`;
  const below = [...host.parentElement.children].filter((own) => own.matches(".legend, .caption") && own.textContent !== "");
  const [top, aside] = [48, 12];
  const width = plot.width + 2 * aside;
  const height = top + plot.height + below.reduce((sum, own) => sum + own.offsetHeight + 16, 16);
  const body = make("body", { style: `padding: 0 ${aside}px` },
    make("style", {}, [...document.querySelectorAll("style")].map((own) => own.textContent)),
    make("h2", { style: "position: absolute; font-size: 1rem" }, name),
    make("div", { style: `height: ${top + plot.height}px` }), below.map((own) => own.cloneNode(true)));
  const size = `width="${width}" height="${height}"`;
  const svg = `<svg xmlns="http://www.w3.org/2000/svg" ${size} data-theme="${document.documentElement.dataset.theme}">`
    + `<foreignObject ${size}>${new XMLSerializer().serializeToString(body)}</foreignObject></svg>`;
  const words = make("img", { src: `data:image/svg+xml,${encodeURIComponent(svg)}` });
  await words.decode();
  const ratio = plot.ctx.canvas.width / plot.width;
  const drawn = (worded) => {
    const [wide, high] = worded ? [width, height] : [plot.width, plot.height];
    const canvas = make("canvas", { width: Math.round(wide * ratio), height: Math.round(high * ratio) });
    const ctx = canvas.getContext("2d");
    ctx.fillStyle = themed("ground");
    ctx.fillRect(0, 0, canvas.width, canvas.height);
    if (worded) ctx.drawImage(words, 0, 0, canvas.width, canvas.height);
    const [left, down] = worded ? [aside, top] : [0, 0];
    ctx.drawImage(plot.ctx.canvas, Math.round(left * ratio), Math.round(down * ratio));
    canvas.toBlob((blob) => {
      const link = make("a", { download: `${name.replace(/[^\p{L}\p{N}._=]+/gu, "-")}.png`, href: URL.createObjectURL(blob) });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    });
  };
  try {
    drawn(true);
  } catch {
    drawn(false);
  }
}

/** Draws shapes at values of the axes. */
class Pen {
  constructor(plot) {
    this.plot = plot;
    this.ctx = plot.ctx;
    this.ratio = devicePixelRatio;
  }

  /** Position of a value on the canvas, in device pixels. */
  x(value) {
    return this.plot.valToPos(value, "x", true);
  }

  y(value) {
    return this.plot.valToPos(value, "y", true);
  }

  /** A line through places; it is interrupted at places with NaN. */
  line(xs, ys, colour, { width = 1.5, dash = [] } = {}) {
    const { ctx, ratio } = this;
    ctx.beginPath();
    let drawn = false;
    for (let i = 0; i < xs.length; i += 1) {
      const [x, y] = [this.x(xs[i]), this.y(ys[i])];
      if (Number.isFinite(x) && Number.isFinite(y)) {
        if (drawn) ctx.lineTo(x, y);
        else ctx.moveTo(x, y);
        drawn = true;
      } else {
        drawn = false;
      }
    }
    ctx.strokeStyle = colour;
    ctx.lineWidth = width * ratio;
    ctx.setLineDash(dash.map((length) => length * ratio));
    ctx.stroke();
    ctx.setLineDash([]);
  }

  /** Small squares, which are drawn faster than discs. */
  dots(xs, ys, colour, size = 3) {
    const { ctx, ratio } = this;
    const side = Math.max(1, size * ratio);
    ctx.fillStyle = colour;
    for (let i = 0; i < xs.length; i += 1) {
      const [x, y] = [this.x(xs[i]), this.y(ys[i])];
      if (Number.isFinite(x) && Number.isFinite(y)) ctx.fillRect(x - side / 2, y - side / 2, side, side);
    }
  }

  /** A symbol: `disc`, `square`, `diamond`, `triangle`, `cross`, `plus` or `bar`. */
  mark(x, y, shape, fill, edge, size = 5) {
    const { ctx, ratio } = this;
    const [a, b, r] = [this.x(x), this.y(y), size * ratio];
    if (!Number.isFinite(a) || !Number.isFinite(b)) return;
    const corners = {
      square: [[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
      diamond: [[0, -1.2], [1.2, 0], [0, 1.2], [-1.2, 0]],
      triangle: [[0, -1.1], [1.1, 0.8], [-1.1, 0.8]],
    }[shape];
    ctx.beginPath();
    if (corners) {
      corners.forEach(([p, q], i) => ctx[i === 0 ? "moveTo" : "lineTo"](a + r * p, b + r * q));
      ctx.closePath();
    } else if (shape === "disc") {
      ctx.arc(a, b, r, 0, 2 * Math.PI);
    } else {
      const ends = { cross: [[-1, -1, 1, 1], [-1, 1, 1, -1]], plus: [[-1, 0, 1, 0], [0, -1, 0, 1]], bar: [[0, -1, 0, 1]] }[shape];
      for (const [p, q, s, t] of ends) {
        ctx.moveTo(a + r * p, b + r * q);
        ctx.lineTo(a + r * s, b + r * t);
      }
    }
    ctx.fillStyle = fill;
    ctx.fill();
    ctx.strokeStyle = edge;
    ctx.lineWidth = 1.3 * ratio;
    ctx.stroke();
  }

  /** Vertical lines from low to high values. */
  bars(xs, lows, highs, colour, width = 1) {
    const { ctx, ratio } = this;
    ctx.beginPath();
    for (let i = 0; i < xs.length; i += 1) {
      const [x, low, high] = [this.x(xs[i]), this.y(lows[i]), this.y(highs[i])];
      if (Number.isNaN(x + low + high)) continue;
      ctx.moveTo(x, low);
      ctx.lineTo(x, high);
    }
    ctx.strokeStyle = colour;
    ctx.lineWidth = width * ratio;
    ctx.stroke();
  }

  /** Index of the place that is nearest to a position in pixels of the page, at most `most` pixels away; −1 if there is none. */
  nearest(xs, ys, left, top, most = 18) {
    const { ratio, plot } = this;
    const [a, b] = [left * ratio + plot.bbox.left, top * ratio + plot.bbox.top];
    let [found, least] = [-1, (most * ratio) ** 2];
    for (let i = 0; i < xs.length; i += 1) {
      const distance = (this.x(xs[i]) - a) ** 2 + (this.y(ys[i]) - b) ** 2;
      if (distance < least) [found, least] = [i, distance];
    }
    return found;
  }
}
