// Lays out the views, and starts each when it is first shown.

const VIEWS = [
  { id: "map", name: "Map", is: () => POINTS !== null && POINTS.rows > 0, start: startPoints },
  { id: "branches", name: "Branches", is: () => (TABLES.get("branches")?.rows ?? 0) > 0, start: startBranches },
  { id: "trajectory", name: "Trajectory", is: () => (TABLES.get("trace")?.rows ?? 0) > 0, start: startTrajectory },
  { id: "tables", name: "Tables", is: () => TABLES.size > 0, start: startTables },
  { id: "run", name: "Run", is: () => true, start: startAbout },
].filter((view) => view.is());

const KEYS = [
  ["arrow keys, on the map", "move the selected point"],
  ["arrow keys, on branches", "move along a branch, or to another one"],
  ["arrow keys, on a row of points", "go to other rows"],
  ["Enter, on a row of points", "select the point and show it on the map"],
  ["drag, in a plot", "zoom"],
  ["double click, in a plot", "show the whole plot again"],
  ["Tab, Shift+Tab", "move between controls"],
  ["?", "this help"],
];

/** Creates the elements of the views, before anything is drawn. */
function layOut() {
  const plot = (label) => make("div", { class: "plot", role: "img", "aria-label": label });
  const controls = () => make("div", { class: "controls" });
  const interactive = (label) => make("div", { class: "plot", role: "application", tabindex: "0", "aria-label": label });
  document.getElementById("map").append(
    make("div", { class: "picture-side" }, controls(), interactive("Map"), make("ul", { class: "legend" }), make("p", { class: "caption" })),
    make("aside", { id: "detail", "aria-label": "The selected point" }));
  document.getElementById("branches").append(
    make("div", { class: "picture-side" }, controls(), interactive("Branches"), make("ul", { class: "legend" })),
    make("aside", { id: "orbit", "aria-label": "The selected orbit", "aria-live": "polite" }, make("p", { class: "soft" }, "Click an orbit or a bifurcation, or press an arrow key on the picture, to see all columns.")));
  document.getElementById("trajectory").append(controls(), plot("Trajectory"), make("p", { class: "caption" }));
  document.getElementById("tables").append(
    controls(), make("p", { class: "caption", "aria-live": "polite" }), make("div", { class: "empty" }),
    make("div", { class: "rows scroll", tabindex: "0", role: "region", "aria-label": "Rows of the table" }));
  document.getElementById("help").append(
    make("h2", {}, "Keys"),
    make("dl", {}, KEYS.flatMap(([key, what]) => [make("dt", {}, key), make("dd", {}, what)])),
    make("form", { method: "dialog" }, make("button", {}, "Close")));
  document.getElementById("views").append(...VIEWS.map(({ id, name }) => make("a", { href: `#${id}` }, name)));
  document.getElementById("job").textContent = HEAD.job ?? HEAD.folder;
  document.getElementById("state").textContent = stateWords();
  if (HEAD.left_out.length > 0) {
    const note = document.getElementById("left-out");
    note.hidden = false;
    note.textContent = `Left out of this page to limit its size: ${HEAD.left_out.join("; ")}. Raise atlas report --most-bytes to include more.`;
  }
}

/** `complete · 80 points · atlas 0.1.0 (…)`. */
function stateWords() {
  const words = [];
  if (HEAD.state === "interrupted") words.push(`interrupted: ${count(HEAD.points)} of ${plural(HEAD.expected, "point")}`);
  else if (HEAD.points !== undefined && POINTS) words.push(...(HEAD.state ? [HEAD.state] : []), plural(HEAD.points, "point"));
  const program = HEAD.runs[0]?.program;
  if (program) words.push(`computed by ${program.name} ${program.version}${program.commit ? ` (${program.commit})` : ""}`);
  if ((HEAD.warnings ?? []).length > 0) words.push(plural(HEAD.warnings.length, "warning"));
  return words.join(" · ");
}

async function startPoints() {
  await loadGrid();
  startDetail();
  const section = document.getElementById("map");
  if (variedAxes().length > 0) await startMap();
  else section.classList.add("alone");
  // The picture is drawn first. The first point is selected after that, so that the picture does not wait for it.
  const liveliest = ["chaotic", "transient chaos"]
    .map((name) => HEAD.motions.findIndex((motion) => motion.name === name))
    .find((motion) => motion >= 0) ?? -1;
  const first = () => selectPoint(grid.selected >= 0 ? grid.selected : Math.max(0, grid.motion.indexOf(liveliest)));
  requestAnimationFrame(() => setTimeout(first));
}

const started = new Set();

/** Shows the view that the address names, else the first view. */
async function show() {
  const view = VIEWS.find(({ id }) => `#${id}` === location.hash) ?? VIEWS[0];
  for (const { id } of VIEWS) document.getElementById(id).hidden = id !== view.id;
  // The view was hidden when its link was followed, so that the browser keeps the scroll position of the view before.
  scrollTo(0, 0);
  document.querySelectorAll("#views a").forEach((link) => {
    if (link.hash === `#${view.id}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  });
  if (view.id === "tables" && started.has("map")) started.delete("tables");
  if (!started.has(view.id)) {
    started.add(view.id);
    await (view.id === "tables" && tables.name ? showTable() : view.start());
  }
  CHARTS.forEach((chart) => chart.fit());
  document.body.dataset.ready = view.id;
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  const button = document.getElementById("theme");
  button.textContent = theme === "dark" ? "Light" : "Dark";
  button.setAttribute("aria-label", `Use ${theme === "dark" ? "light" : "dark"} colours`);
  CHARTS.forEach((chart) => chart.rebuild());
  if (map.chart) drawMap();
  if (branches.chart) drawBranches();
}

function start() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  setTheme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => setTheme(dark.matches ? "dark" : "light"));
  layOut();
  document.getElementById("theme").addEventListener("click", () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
  const help = document.getElementById("help");
  document.getElementById("help-button").addEventListener("click", () => help.showModal());
  addEventListener("keydown", (event) => {
    const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
    if (event.key === "?" && !typing && !help.open) help.showModal();
  });
  let before = null;
  addEventListener("beforeprint", () => {
    before = document.documentElement.dataset.theme;
    setTheme("light");
  });
  addEventListener("afterprint", () => setTheme(before));
  addEventListener("hashchange", show);
  show();
}

start();
