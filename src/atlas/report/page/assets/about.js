// The view "Run": warnings, the summary of `atlas show`, the record of the run and its manifest.

function startAbout() {
  const section = document.getElementById("run");
  const part = (title, ...content) => make("section", {}, make("h2", {}, title), content);
  const text = (own, label) => make("pre", { tabindex: "0", role: "region", "aria-label": label }, own);
  const parts = [];
  const warnings = HEAD.warnings ?? [];
  if (warnings.length > 0) parts.push(part("Warnings", make("ul", { class: "warnings" }, warnings.map((warning) => make("li", {}, warning)))));
  if (HEAD.summary) parts.push(part("Summary", text(HEAD.summary, "Summary, as atlas show prints it")));
  parts.push(part("Checksums", make("p", { id: "checksums" }, checksums())));
  if (HEAD.left_out.length > 0) {
    parts.push(part("Not in this page", make("ul", {}, HEAD.left_out.map((line) => make("li", {}, line))),
      make("p", {}, "Raise atlas report --most-bytes to include more.")));
  }
  HEAD.runs.forEach((run, index) => {
    const { manifest, ...record } = run;
    const title = HEAD.runs.length > 1 ? `Record of the run, part ${index + 1}` : "Record of the run";
    parts.push(part(title, plainTable(title, ["what", "value"], flat(record))));
    if (index === 0) parts.push(part("Manifest", text(manifest, "The manifest as it was run")));
  });
  parts.push(part("This page", make("p", {}, `Written by ${HEAD.program}; draws with uPlot 1.6.32 (MIT).`)));
  section.replaceChildren(...parts);
}

function checksums() {
  if (HEAD.runs.length === 0) return "There is no run.json, so no table of a run was checked.";
  return `${plural(HEAD.checked, "table")} matched the checksums in run.json when this page was written.`;
}

/** SI units of the numbers in a record, by the last word of their names. */
const RECORD_UNITS = {
  memory: "B", bytes: "B", after: "s", wall_time: "s", wall_time_low: "s", wall_time_high: "s", wall_time_per_cycle: "s", cycles_per_second: "1/s",
};

/** A value of the record with its unit. */
function recorded(name, value) {
  const unit = typeof value === "number" ? RECORD_UNITS[name.split(".").at(-1)] : undefined;
  return unit ? `${value} ${unit}` : String(value);
}

/** A record as lines: a name with dots, and a value. */
function flat(value, name = "") {
  if (value === null) return [];
  if (Array.isArray(value) && value.every((entry) => typeof entry !== "object")) return value.length > 0 ? [[name, value.join(", ")]] : [];
  if (typeof value !== "object") return [[name, recorded(name, value)]];
  return Object.entries(value).flatMap(([key, own]) => flat(own, name === "" ? key : `${name}.${key}`));
}
