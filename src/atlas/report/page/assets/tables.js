// The view of tables: sorted by any column, and filtered. Only visible rows are in the document.

const ROW_HEIGHT = 26;
/** Number of columns shown at first. */
const FEW_COLUMNS = 14;

const tables = { name: "", sorted: "", ascending: true, filter: "", all: false, rows: [], chosen: [] };

async function startTables() {
  tables.name = TABLES.keys().next().value;
  await showTable();
}

async function showTable() {
  const table = TABLES.get(tables.name);
  tables.chosen = tables.all ? table.columns : table.columns.slice(0, FEW_COLUMNS);
  const words = termsOf(table, tables.filter);
  await table.load(...tables.chosen.map(({ name }) => name), ...table.columns.filter(({ kind }) => kind === "text").map(({ name }) => name),
    ...words.terms.map(({ column }) => column.name), ...(tables.sorted ? [tables.sorted] : []));
  const names = [...TABLES.values()].map(({ name, rows }) => [name, `${name} (${count(rows)})`]);
  const filter = make("input", {
    type: "search", id: "filter", value: tables.filter, placeholder: "class=chaotic lambda_max>0.1",
    title: "Words in the texts of a row, and conditions in SI: COLUMN=VALUE, COLUMN>VALUE, COLUMN<VALUE",
    onchange: () => {
      tables.filter = filter.value;
      showTable();
    },
  });
  const controls = [
    choice("Table", names, tables.name, (name) => {
      Object.assign(tables, { name, sorted: "", filter: "" });
      showTable();
    }, "table-name"),
    make("label", {}, make("span", {}, "Filter"), filter),
    tick(`all ${table.columns.length} columns`, tables.all, (all) => {
      tables.all = all;
      showTable();
    }, "all-columns"),
  ];
  const focused = document.activeElement?.id;
  document.querySelector("#tables .controls").replaceChildren(...controls);
  if (focused) document.getElementById(focused)?.focus();
  tables.rows = rowsThat(table, words);
  sortRows(table);
  const left = table.rows < table.all ? ` of ${count(table.all)} in the folder` : "";
  const fault = words.faults.length > 0 ? ` No such column: ${words.faults.join(", ")}.` : "";
  document.querySelector("#tables .caption").textContent =
    `${count(tables.rows.length)} of ${plural(table.rows, "row")} here${left}.${fault}`;
  const empty = make("details", { class: "soft", hidden: table.empty.length === 0 },
    make("summary", {}, `${plural(table.empty.length, "column")} without a value`), table.empty.join(", "));
  document.querySelector("#tables .empty").replaceChildren(empty);
  drawTable(table);
}

/** The contents of a filter: conditions on columns, words, and names of unknown columns. */
function termsOf(table, text) {
  const [terms, words, faults] = [[], [], []];
  for (const word of text.split(/\s+/).filter((part) => part)) {
    const match = /^([^<>=]+)(<=|>=|<|>|=)(.*)$/.exec(word);
    const column = match && table.column(match[1]);
    if (column) terms.push({ column, sign: match[2], value: match[3] });
    else if (match) faults.push(match[1]);
    else words.push(word.toLowerCase());
  }
  return { terms, words, faults };
}

function rowsThat(table, { terms, words }) {
  const texts = table.columns.filter(({ kind }) => kind === "text");
  const holds = ({ column, sign, value }, row) => {
    if (column.kind === "text") return (column.text(row) ?? "") === value;
    const [own, wanted] = [column.number(row), Number(value)];
    return { "<": own < wanted, ">": own > wanted, "<=": own <= wanted, ">=": own >= wanted, "=": own === wanted }[sign];
  };
  const rows = [];
  for (let row = 0; row < table.rows; row += 1) {
    const has = (word) => texts.some((column) => (column.text(row) ?? "").toLowerCase().includes(word));
    if (terms.every((term) => holds(term, row)) && words.every(has)) rows.push(row);
  }
  return rows;
}

/** Sorts the rows. Rows without a value come last, and rows with equal values keep the order of the file. */
function sortRows(table) {
  const column = table.column(tables.sorted);
  if (column === null) return;
  const sign = tables.ascending ? 1 : -1;
  if (column.kind === "text") {
    const ranks = new Map([...column.values].sort().map((text, rank) => [text, rank]));
    const rank = (row) => (column.codes[row] === 0 ? Infinity : sign * ranks.get(column.text(row)));
    tables.rows.sort((a, b) => (rank(a) === rank(b) ? a - b : rank(a) - rank(b)));
    return;
  }
  const key = (row) => (Number.isNaN(column.number(row)) ? Infinity : sign * column.number(row));
  tables.rows.sort((a, b) => (key(a) === key(b) ? a - b : key(a) - key(b)));
}

/** The text of a cell. A number has all its digits, so that copies are exact. */
function cellText(column, row) {
  if (column.kind === "text") return column.text(row) ?? "";
  if (column.kind === "list") {
    const list = column.list(row);
    if (list === null) return "";
    const texts = Array.from(list.subarray(0, 6), (value) => (Number.isNaN(value) ? "–" : String(value)));
    return texts.join(", ") + (list.length > 6 ? `, … (${list.length})` : "");
  }
  return Number.isNaN(column.values[row]) ? "" : String(column.values[row]);
}

function drawTable(table) {
  const scroll = document.querySelector("#tables .rows");
  const sort = (name) => async () => {
    const again = tables.sorted === name;
    tables.ascending = again ? !tables.ascending : true;
    tables.sorted = name;
    await showTable();
    document.querySelector(`#tables th[data-column="${CSS.escape(name)}"] button`)?.focus();
  };
  const heads = tables.chosen.map(({ name, unit, description, kind }) => {
    const own = tables.sorted === name;
    const arrow = own ? (tables.ascending ? " ▲" : " ▼") : "";
    const words = unit === "" || unit === "1" || unit.includes(" or ") ? name : `${name} [${readable(unit)}]`;
    return make("th", {
      scope: "col", title: description, "data-column": name, class: kind === "text" ? null : "number",
      "aria-sort": own ? (tables.ascending ? "ascending" : "descending") : "none",
    }, make("button", { type: "button", onclick: sort(name) }, words + arrow));
  });
  const body = make("tbody");
  scroll.replaceChildren(make("table", { "aria-rowcount": tables.rows.length + 1 }, make("thead", {}, make("tr", {}, heads)), body));
  const canSelect = table === POINTS;
  // The Tab key goes to one row only; arrow keys move from there.
  let active = Math.max(0, canSelect ? tables.rows.indexOf(grid.selected) : 0);
  const line = (row, place) => make("tr", {
    class: canSelect ? "selectable" : null, "aria-rowindex": place + 2, "aria-selected": canSelect && row === grid.selected ? "true" : null,
    tabindex: canSelect ? (place === active ? "0" : "-1") : null,
    onclick: () => canSelect && chooseRow(row),
    onkeydown: (event) => canSelect && event.key === "Enter" && chooseRow(row),
  }, tables.chosen.map((column) => make("td", { class: column.kind === "text" ? null : "number" }, cellText(column, row))));
  const gap = (rows) => {
    const empty = make("tr", { "aria-hidden": "true" }, make("td", { colspan: tables.chosen.length }));
    empty.style.height = `${rows * ROW_HEIGHT}px`;
    return empty;
  };
  let shown = "";
  const focusActive = () => body.querySelector(`tr[aria-rowindex="${active + 2}"]`)?.focus({ preventScroll: true });
  const fill = () => {
    const first = Math.max(0, Math.floor(scroll.scrollTop / ROW_HEIGHT) - 10);
    const last = Math.min(tables.rows.length, first + Math.ceil(scroll.clientHeight / ROW_HEIGHT) + 20);
    if (shown === `${first} ${last}`) return;
    shown = `${first} ${last}`;
    const lines = tables.rows.slice(first, last).map((row, place) => line(row, first + place));
    const hadFocus = body.contains(document.activeElement);
    body.replaceChildren(...(first > 0 ? [gap(first)] : []), ...lines, ...(last < tables.rows.length ? [gap(tables.rows.length - last)] : []));
    if (!hadFocus) return;
    if (active >= first && active < last) focusActive();
    else scroll.focus({ preventScroll: true });
  };
  body.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10, Home: -tables.rows.length, End: tables.rows.length }[event.key];
    if (step === undefined || !canSelect) return;
    event.preventDefault();
    active = Math.min(Math.max(active + step, 0), tables.rows.length - 1);
    // The head of the table covers the rows above: scroll so that the active row is visible.
    const [top, head] = [active * ROW_HEIGHT, body.previousSibling.offsetHeight];
    scroll.scrollTop = Math.min(Math.max(scroll.scrollTop, top + head + ROW_HEIGHT - scroll.clientHeight), top);
    shown = "";
    fill();
    focusActive();
  });
  scroll.onscroll = fill;
  fill();
}

/** Selects the point of a row of the table, and shows it on the map. */
function chooseRow(row) {
  selectPoint(row);
  location.hash = "#map";
}
