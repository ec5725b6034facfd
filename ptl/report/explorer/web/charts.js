// The learning curves and the probabilities of the skills, both over the episodes, with the cursor.

import { skillColour } from "./colour.js";
import { formatCount } from "./format.js";
import { svg } from "./svg.js";

export const MARGIN = { left: 46, right: 16 };

/** Mean of the last `width` numbers (fewer at the beginning). */
export function runningMean(numbers, width) {
  let sum = 0;
  return numbers.map((number, i) => {
    sum += number - (i >= width ? numbers[i - width] : 0);
    return sum / Math.min(i + 1, width);
  });
}

/** Column of an episode (counted from 1). */
function columnOf(episode, count, width) {
  const room = width - MARGIN.left - MARGIN.right;
  return MARGIN.left + (count > 1 ? ((episode - 1) / (count - 1)) * room : room / 2);
}

/** Episode under a column. */
function episodeAt(x, count, width) {
  const share = (x - MARGIN.left) / (width - MARGIN.left - MARGIN.right);
  return Math.min(count, Math.max(1, Math.round(1 + share * (count - 1))));
}

function line(points, className, colour) {
  const path = points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
  const element = svg("path", { d: path, class: className });
  element.style.stroke = colour;
  return element;
}

function episodeTicks(count) {
  const step = [1, 2, 5, 10, 20, 25, 50, 100, 200, 500, 1000, 5000, 10000].find((size) => count / size <= 5) ?? count;
  return [1, ...Array.from({ length: Math.floor(count / step) }, (_, i) => (i + 1) * step)].filter(
    (tick, i, all) => i === 0 || tick > all[0] + step / 3,
  );
}

/** Let a pointer move the cursor of a chart. */
export function followPointer(element, episodes, move) {
  const report = (event) => {
    const box = element.getBoundingClientRect();
    move(episodeAt(event.clientX - box.left, episodes(), box.width));
  };
  element.addEventListener("pointerdown", report);
  element.addEventListener("pointermove", (event) => event.buttons && report(event));
}

/** Steps per episode on a log scale, with the mean of `window` episodes. series: [{label, colour, steps}] */
export function drawCurves(element, series, window, shortest, episode) {
  const [width, height] = [element.clientWidth, element.clientHeight];
  const [top, bottom] = [10, height - 24];
  const count = Math.max(...series.map(({ steps }) => steps.length));
  const all = series.flatMap(({ steps }) => steps);
  const low = Math.log10(Math.max(1, Math.min(shortest, ...all))) - 0.08;
  const high = Math.max(low + 1, Math.log10(Math.max(...all)) + 0.05);
  const y = (steps) => bottom - ((Math.log10(steps) - low) / (high - low)) * (bottom - top);
  const x = (i) => columnOf(i + 1, count, width);
  const parts = [];
  for (const tick of stepTicks(low, high)) {
    const at = y(tick);
    parts.push(svg("line", { x1: MARGIN.left, x2: width - MARGIN.right, y1: at, y2: at, class: "grid" }));
    parts.push(svg("text", { x: MARGIN.left - 7, y: at + 4, class: "tick end" }, shortCount(tick)));
  }
  parts.push(...episodeTicks(count).map((tick) => episodeTick(tick, count, width, height)));
  const base = y(shortest);
  parts.push(svg("line", { x1: MARGIN.left, x2: width - MARGIN.right, y1: base, y2: base, class: "shortest" }));
  for (const { steps, colour } of series) {
    parts.push(line(steps.map((value, i) => [x(i), y(value)]), "raw", colour));
  }
  for (const { steps, colour } of series) {
    parts.push(line(runningMean(steps, window).map((value, i) => [x(i), y(value)]), "mean", colour));
  }
  parts.push(cursorLine(episode, count, width, top, bottom));
  for (const { steps, colour } of series) {
    const dot = svg("circle", { cx: x(episode - 1), cy: y(steps[episode - 1]), r: 5, class: "dot" });
    dot.style.fill = colour;
    parts.push(dot);
  }
  element.replaceChildren(...parts);
}

/** Ticks of a log axis between two powers of ten (exponents): 1, or 1, 2 and 5, of each decade. */
function stepTicks(low, high) {
  const factors = high - low < 2 ? [1, 2, 5] : [1];
  const powers = Array.from({ length: Math.ceil(high) - Math.floor(low) + 1 }, (_, i) => 10 ** (Math.floor(low) + i));
  return powers
    .flatMap((power) => factors.map((factor) => factor * power))
    .filter((tick) => tick >= 10 ** low && tick <= 10 ** high);
}

function shortCount(number) {
  return number >= 1e6 ? `${number / 1e6} M` : number >= 1000 ? `${formatCount(number / 1000)} k` : String(number);
}

function episodeTick(tick, count, width, height) {
  return svg("text", { x: columnOf(tick, count, width), y: height - 6, class: "tick middle" }, String(tick));
}

function cursorLine(episode, count, width, top, bottom) {
  const x = columnOf(episode, count, width);
  return svg("line", { x1: x, x2: x, y1: top, y2: bottom, class: "cursor" });
}

/** Probabilities of the candidates (one row each), stacked. */
export function drawChances(element, chances, episode, chosen) {
  const [width, height] = [element.clientWidth, element.clientHeight];
  const [top, bottom] = [6, height - 24];
  const count = chances[0].length;
  const x = (i) => columnOf(i + 1, count, width);
  const y = (share) => bottom - share * (bottom - top);
  const floor = new Float64Array(count);
  const parts = [0, 0.5, 1].map((share) =>
    svg("text", { x: MARGIN.left - 7, y: y(share) + 4, class: "tick end" }, `${100 * share}%`),
  );
  chances.forEach((shares, candidate) => {
    const lower = shares.map((_, i) => [x(i), y(floor[i])]);
    shares.forEach((share, i) => { floor[i] += share; });
    const upper = shares.map((_, i) => [x(i), y(floor[i])]);
    const outline = [...lower, ...upper.reverse()].map(([a, b]) => `${a.toFixed(1)} ${b.toFixed(1)}`).join("L");
    const band = svg("path", { d: `M${outline}Z`, class: chosen > 0 && chosen !== candidate ? "band faint" : "band" });
    band.style.fill = skillColour(candidate);
    parts.push(band);
  });
  parts.push(...episodeTicks(count).map((tick) => episodeTick(tick, count, width, height)));
  parts.push(cursorLine(episode, count, width, top, bottom));
  element.replaceChildren(...parts);
}
