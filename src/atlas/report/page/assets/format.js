// Numbers and units as text: SI with prefixes, as in the pictures of `atlas plot`.

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/** A number as text with a true minus sign. */
function minus(text) {
  return text.replace("-", "−");
}

/** `10⁻⁶`. */
function powerOfTen(exponent) {
  const raised = (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)]);
  return `10${[...String(exponent)].map(raised).join("")}`;
}

/** A number with `count` significant digits, without trailing zeros; empty for NaN. */
function digits(value, count = 4) {
  if (Number.isNaN(value)) return "";
  if (value === 0) return "0";
  const before = Math.floor(Math.log10(Math.abs(value))) + 1;
  const rounded = Number(value.toPrecision(before > count && before <= 6 ? before : count));
  const size = Math.abs(rounded);
  if (size >= 1e-3 && size < 1e6) return minus(String(rounded));
  const [mantissa, exponent] = rounded.toExponential().split("e");
  return `${minus(mantissa)}·${powerOfTen(Number(exponent))}`;
}

/** A unit as text, such as m/s²; a dash if dimensionless. */
function readable(unit) {
  if (unit === "" || unit === "1") return "–";
  return unit.replaceAll("*", "·").replace(/\^(-?\d)/g, (power, exponent) => powerOfTen(exponent).slice(2));
}

/** The scaled unit for values up to `largest`: the factor from SI, and the unit as text. */
function scaledUnit(unit, largest) {
  const name = readable(unit);
  if (!(largest > 0) || !Number.isFinite(largest)) return [1, name];
  if (HEAD.prefixable.includes(unit) && largest >= 1e-12 && largest < 1e15) {
    const found = PREFIXES.find(([size]) => largest >= size * 0.999999) ?? PREFIXES.at(-1);
    return [1 / found[0], found[1] + name];
  }
  if (largest >= 1e-3 && largest < 1e5) return [1, name];
  const exponent = 3 * Math.floor(Math.log10(largest) / 3);
  const power = powerOfTen(exponent);
  return [10 ** -exponent, name === "–" ? power : `${power} ${name}`];
}

/** A number with its unit, which may begin with a power of ten. */
function joined(number, unit) {
  if (unit === "–") return number;
  if (!unit.startsWith("10")) return `${number} ${unit}`;
  return number.includes("±") ? `(${number})·${unit}` : `${number}·${unit}`;
}

/** `12.5 µm`. */
function withUnit(value, unit) {
  if (Number.isNaN(value)) return "";
  const [factor, name] = scaledUnit(unit, Math.abs(value));
  return joined(digits(value * factor), name);
}

/** `12.5 ± 0.3 µm`: value and standard error in one unit. */
function withError(value, error, unit) {
  if (Number.isNaN(value)) return "";
  if (Number.isNaN(error)) return withUnit(value, unit);
  const [factor, name] = scaledUnit(unit, Math.max(Math.abs(value), Math.abs(error)));
  return joined(`${digits(value * factor)} ± ${digits(error * factor, 2)}`, name);
}

/** Factor from SI to the unit in which plots show an axis, and that unit: the unit of the manifest, else a scaled unit. */
function plotted(axis, values) {
  return axis.shown ? [axis.factor, readable(axis.shown)] : scaledUnit(axis.unit, Math.max(...(extent(values) ?? [1]).map(Math.abs)));
}

/** `6000 rpm`: a value of an axis in the unit of the manifest, else in a scaled unit. */
function axisText(axis, value) {
  if (!axis.shown) return withUnit(value, axis.unit);
  return Number.isNaN(value) ? "" : joined(digits(value * axis.factor), readable(axis.shown));
}

/** A whole number with separated thousands. */
function count(value) {
  return String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** `1 point`, `3 points`. */
function plural(number, noun) {
  return `${count(number)} ${noun}${number === 1 ? "" : "s"}`;
}

/** The smallest and the largest of some numbers; null without numbers. `positive` skips numbers that are not positive. */
function extent(values, positive = false) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (Number.isNaN(value) || (positive && value <= 0)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : null;
}

/** A range with a margin at both ends: a part of its width, or of its size if it has no width. */
function padded(range, part = 0.04) {
  const [low, high] = range ?? [0, 1];
  const width = high - low > 1e-9 * Math.max(Math.abs(low), Math.abs(high)) ? high - low : Math.abs(high) || 1;
  return [low - part * width, high + part * width];
}

/** A logarithmic range with a margin at both ends. */
function paddedLog(range) {
  const [low, high] = range ?? [0.1, 1];
  const margin = high > low * 1.001 ? (high / low) ** 0.04 : 2;
  return [low / margin, high * margin];
}
