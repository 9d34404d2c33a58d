"use strict";
// The tables of the folder. Each column is an array of the page, which is inflated only when it is needed, so that a page of
// a hundred thousand points opens quickly. The arrays of the first picture come before this code in the file, all others
// come after it: the code runs while the browser still reads the rest of the file.

const HEAD = JSON.parse(document.getElementById("head").textContent);

/** The element with an array of the page. Waits until it is complete: until another element follows, or the page is read. */
async function arrived(number) {
  for (;;) {
    const element = document.getElementById(`block-${number}`);
    if (element?.nextElementSibling || document.readyState !== "loading") return element;
    await more();
  }
}

/** Resolves when the browser has read more elements of the page, or all. */
function more() {
  return new Promise((resolve) => {
    const seen = new MutationObserver(() => {
      seen.disconnect();
      resolve();
    });
    seen.observe(document.body, { childList: true });
    document.addEventListener("DOMContentLoaded", resolve, { once: true });
  });
}

/** Inflated bytes of an array of the page. */
async function inflated(number) {
  const text = (await arrived(number)).textContent;
  const bytes = Uint8Array.fromBase64
    ? Uint8Array.fromBase64(text)
    : Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new DecompressionStream("deflate");
  const writer = stream.writable.getWriter();
  writer.write(bytes);
  writer.close();
  return new Uint8Array(await new Response(stream.readable).arrayBuffer());
}

/** Numbers from their byte planes: all first bytes, then all second bytes, and so on. */
async function numbers(number, Type = Float64Array) {
  const planes = await inflated(number);
  const size = Type.BYTES_PER_ELEMENT;
  const count = planes.length / size;
  const bytes = new Uint8Array(planes.length);
  for (let plane = 0; plane < size; plane += 1) {
    for (let row = 0, at = plane * count; row < count; row += 1, at += 1) {
      bytes[row * size + plane] = planes[at];
    }
  }
  return new Type(bytes.buffer);
}

/** A column of a table. Call `load` before all other methods. */
class Column {
  constructor(told) {
    Object.assign(this, told);
    this.loading = null;
    this.isLoaded = false;
  }

  load() {
    this.loading ??= this.read().then(() => {
      this.isLoaded = true;
    });
    return this.loading;
  }

  async read() {
    if (this.kind === "text") {
      this.codes = await numbers(this.block, Uint32Array);
      this.values = JSON.parse(new TextDecoder().decode(await inflated(this.texts)));
      return;
    }
    this.values = await numbers(this.block);
    if (this.kind === "list") {
      this.sizes = await numbers(this.lengths, Uint32Array);
      this.starts = new Uint32Array(this.sizes.length);
      let start = 0;
      for (let row = 0; row < this.sizes.length; row += 1) {
        this.starts[row] = start;
        start += this.length(row);
      }
    }
  }

  /** Number of elements of the list of a row; 0 without a list. */
  length(row) {
    return this.sizes[row] === 0xffffffff ? 0 : this.sizes[row];
  }

  /** The number of a row, or an element of its list; NaN if there is none. */
  number(row, element = 0) {
    if (this.kind === "text") return NaN;
    if (this.kind !== "list") return this.values[row];
    return element < this.length(row) ? this.values[this.starts[row] + element] : NaN;
  }

  /** The text of a row; null if there is none. */
  text(row) {
    const code = this.codes[row];
    return code === 0 ? null : this.values[code - 1];
  }

  /** The list of a row; null if there is none. */
  list(row) {
    if (this.sizes[row] === 0xffffffff) return null;
    return this.values.subarray(this.starts[row], this.starts[row] + this.sizes[row]);
  }

  /** Name of an element of its lists. */
  element(index) {
    return this.elements?.[index] ?? String(index + 1);
  }

  /** Whether a row has a value. */
  has(row) {
    if (this.kind === "text") return this.codes[row] !== 0;
    if (this.kind === "list") return this.sizes[row] !== 0xffffffff;
    return !Number.isNaN(this.values[row]);
  }
}

/** A table. Its rows are in ascending `point_id`, if it has this column. */
class Table {
  constructor(told) {
    this.name = told.name;
    this.all = told.rows;
    this.rows = told.kept;
    this.empty = told.empty;
    this.columns = told.columns.map((column) => new Column(column));
    this.byName = new Map(this.columns.map((column) => [column.name, column]));
  }

  column(name) {
    return this.byName.get(name) ?? null;
  }

  /** Loads the named columns, or all without names. Returns them; null for a column that does not exist. */
  async load(...names) {
    const chosen = names.length > 0 ? names.map((name) => this.column(name)) : this.columns;
    await Promise.all(chosen.map((column) => column?.load()));
    return chosen;
  }

  /** First row of a point, and the row after its last. */
  async rowsOf(point) {
    const [ids] = await this.load("point_id");
    if (ids === null) return [0, 0];
    const bound = (wanted) => {
      let [low, high] = [0, this.rows];
      while (low < high) {
        const middle = (low + high) >> 1;
        if (ids.values[middle] < wanted) low = middle + 1;
        else high = middle;
      }
      return low;
    };
    return [bound(point), bound(point + 1)];
  }
}

const TABLES = new Map(HEAD.tables.map((told) => [told.name, new Table(told)]));

/** The column with the standard errors of another column; null if there is none. */
function errorsOf(table, name) {
  return table.column(name === "lambda_max" ? "lambda_stderr" : `${name}_stderr`);
}
