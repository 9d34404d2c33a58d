// Elements of the page. All data from files are inserted by this code, as text and never as markup.

/** An element with attributes, handlers (`onclick`) and children, which are elements or texts. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/** A labelled choice of `[value, text]` pairs, or of groups of them by name; `change` gets the value. */
function choice(label, options, chosen, change, id) {
  const option = ([value, text]) => make("option", { value, selected: value === chosen }, text);
  const entries = Array.isArray(options)
    ? options.map(option)
    : Object.entries(options).map(([name, group]) => make("optgroup", { label: name }, group.map(option)));
  const select = make("select", { id, onchange: () => change(select.value) }, entries);
  return make("label", {}, make("span", {}, label), select);
}

/** A labelled box to tick. */
function tick(label, on, change, id) {
  const box = make("input", { type: "checkbox", id, checked: on, onchange: () => change(box.checked) });
  return make("label", { class: "tick" }, box, make("span", {}, label));
}

/** A square in a colour, hatched if the cells of a map are. */
function swatch(colour, hatched = false) {
  const square = make("span", { class: hatched ? "swatch hatched" : "swatch", "aria-hidden": "true" });
  square.style.backgroundColor = colour;
  return square;
}

/** A sample of a line, solid or dashed. */
function stroke(colour, broken) {
  const line = make("span", { class: "stroke", "aria-hidden": "true" });
  line.style.borderTop = `3px ${broken ? "dashed" : "solid"} ${colour}`;
  return line;
}

/** A table of texts below heads; cells of numbers are `numeric`. */
function plainTable(caption, heads, rows, numeric = () => false) {
  const cell = (text, column) => make("td", { class: numeric(column) ? "number" : null }, text);
  return make(
    "div",
    { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    make(
      "table",
      {},
      make("thead", {}, make("tr", {}, heads.map((head, column) => make("th", { scope: "col", class: numeric(column) ? "number" : null }, head)))),
      make("tbody", {}, rows.map((row) => make("tr", {}, row.map(cell)))),
    ),
  );
}

/** A table of names and values, with a description below each name. */
function describedTable(rows) {
  return make("table", { class: "statistics" }, make("tbody", {}, rows.map(([name, value, description]) =>
    make("tr", {}, make("th", { scope: "row" }, name, make("small", {}, description)), make("td", { "data-column": name }, value)))));
}

/** The box beside the pointer. */
const tip = {
  show(event, lines) {
    const box = document.getElementById("tip");
    box.replaceChildren(...lines.map((line, index) => make(index === 0 ? "strong" : "span", {}, line)));
    box.hidden = false;
    const { offsetWidth: width, offsetHeight: height } = box;
    const left = event.clientX + 16 + width < innerWidth ? event.clientX + 16 : event.clientX - 16 - width;
    const top = event.clientY + 16 + height < innerHeight ? event.clientY + 16 : event.clientY - 16 - height;
    box.style.left = `${Math.max(4, left)}px`;
    box.style.top = `${Math.max(4, top)}px`;
  },
  hide() {
    document.getElementById("tip").hidden = true;
  },
};
