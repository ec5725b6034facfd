// One map on a canvas: walls, coloured cells, arrows, subgoals, the agent and its trail.

import { inkOn, mixColours, parseHex, skillColour, toHex, viridis } from "./colour.js";
import { formatCount, formatNumber } from "./format.js";
import { MOVES } from "./world.js";

const LARGEST_CELL = 34; // CSS pixels
const ZOOMED_CELL = 18;
const ARROWS_FROM = 5; // smaller cells show no arrows

const FARTHEST = 1000; // steps to the goal at the dark end
const MOST_VISITS = 1000; // at the bright end

/** How values, the subgoal metric and visits become a place t in [0, 1] of the colour map; null is no colour. */
export function layerScale(layer, gamma) {
  if (layer === "metric") {
    return {
      place: (share) => (share > 0 ? share : null),
      title: "Subgoal metric (frequency × distance) after this task",
      ticks: [[0, "0"], [0.5, "0.5"], [1, "1"]],
    };
  }
  if (layer === "visits") {
    return {
      place: (count) => (count > 0 ? Math.min(1, Math.log(count) / Math.log(MOST_VISITS)) : null),
      title: "How often the cell was entered so far",
      ticks: [[0, "once"], [1 / 3, "10"], [2 / 3, "100"], [1, "1000 or more"]],
    };
  }
  if (gamma === 1) {
    return { place: (value) => value || null, title: "Value max Q", ticks: [[0, "0"], [1, "1"]] };
  }
  return {
    place: (value) => {
      const steps = goalSteps(value, gamma);
      return Number.isFinite(steps) ? 1 - Math.min(1, Math.log(Math.max(1, steps)) / Math.log(FARTHEST)) : null;
    },
    title: "Value max Q, as the number of steps to the goal it stands for",
    ticks: [[0, "1000 or more"], [1 / 3, "100"], [2 / 3, "10"], [1, "1 step"]],
  };
}

/** Steps to the goal that a value stands for: a goal m steps away is worth gamma ** (m - 1). */
export function goalSteps(value, gamma) {
  return value > 0 ? 1 + Math.log(value) / Math.log(gamma) : Infinity;
}

function placeInWords(world, state) {
  const [row, column] = world.cells[state];
  return `Row ${row}, column ${column}`;
}

function arrowInWords(policy, state, actions) {
  return policy[state] < 0 ? "no action known" : actions[policy[state]];
}

/** A cell in words: how often it was entered, and its arrow if a policy is shown. */
export function describeVisits(world, task, state, count, policy, actions) {
  const place = placeInWords(world, state);
  if (state === task.goal) return `${place}: goal ${task.name}.`;
  const times = count === 1 ? "once" : `${formatCount(count)} times`;
  const arrow = policy ? `; ${arrowInWords(policy, state, actions)}` : "";
  return `${place}: ${count ? `entered ${times}` : "not entered yet"}${arrow}.`;
}

/** A cell in words: its learned value and its arrow. */
export function describeCell(world, task, state, policy, actions, gamma) {
  const place = placeInWords(world, state);
  if (state === task.goal) return `${place}: goal ${task.name}.`;
  const value = task.value[state];
  const arrow = arrowInWords(policy, state, actions);
  if (value === 0) return `${place}: value 0, never informed; ${arrow}.`;
  const steps = gamma === 1 ? "" : ` (as ${formatNumber(goalSteps(value, gamma))} steps to the goal)`;
  return `${place}: value ${formatNumber(value)}${steps}; ${arrow}.`;
}

/** The map in letters, a line a row, with `sign(state)` on the free cells. */
export function mapAsText(world, task, sign, subgoals) {
  const grid = Array.from({ length: world.rows }, () => Array(world.columns).fill("#"));
  world.cells.forEach(([row, column], state) => { grid[row][column] = sign(state); });
  const put = (state, letter) => {
    const [row, column] = world.cells[state];
    grid[row][column] = letter;
  };
  subgoals.forEach((state, i) => put(state, String((i + 1) % 10)));
  put(world.start, "I");
  put(task.goal, task.name);
  return grid.map((line) => line.join("")).join("\n");
}

/** Draws into a canvas; `scene` says what (see `draw`). */
export class MapView {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  /** Choose the size of a cell for the width at hand, so that cells fall on whole device pixels. */
  fit(world, width, tallest, zoomed) {
    const ratio = window.devicePixelRatio || 1;
    const wanted = zoomed ? ZOOMED_CELL : Math.min(LARGEST_CELL, width / world.columns, tallest / world.rows);
    this.unit = Math.max(1, Math.floor(wanted * ratio)); // device pixels
    this.ratio = ratio;
    this.world = world;
    const [w, h] = [this.unit * world.columns, this.unit * world.rows];
    if (this.canvas.width !== w || this.canvas.height !== h) [this.canvas.width, this.canvas.height] = [w, h];
    this.canvas.style.width = `${w / ratio}px`;
    this.canvas.style.height = `${h / ratio}px`;
    return this.unit / ratio;
  }

  /** State under a mouse event, -1 for a wall. */
  stateUnder(event) {
    const box = this.canvas.getBoundingClientRect();
    const column = Math.floor(((event.clientX - box.left) * this.ratio) / this.unit);
    const row = Math.floor(((event.clientY - box.top) * this.ratio) / this.unit);
    const { rows, columns, stateAt } = this.world;
    return row < 0 || column < 0 || row >= rows || column >= columns ? -1 : stateAt[row * columns + column];
  }

  /**
   * scene: colours {floor, wall, ink, paper, ...}, task, heat (number per state), scale, faded, policy (or null),
   * markers [{state, candidate, label}], found (state or -1), trail [{states, colour}], thin (trail), agent {state, colour} or null,
   * inspected (state or -1).
   */
  draw(scene) {
    this.scene = scene;
    const { context: c } = this;
    c.fillStyle = scene.colours.wall;
    c.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.#drawCells();
    this.#drawLetters();
    for (const { states, colour } of scene.trail) this.#drawLine(states, colour, scene.thin);
    if (scene.found >= 0) this.#drawDiamond(scene.found, scene.colours.paper, scene.colours.ink, "+");
    for (const { state, candidate, label } of scene.markers) {
      const fill = skillColour(candidate);
      this.#drawDiamond(state, fill, inkOn(parseHex(fill)), label);
    }
    this.#drawEnds();
    if (scene.agent) this.#drawAgent(scene.agent);
    if (scene.inspected >= 0) this.#drawFrame(scene.inspected);
  }

  #corner(state) {
    const [row, column] = this.world.cells[state];
    return [column * this.unit, row * this.unit];
  }

  #centre(state) {
    const [x, y] = this.#corner(state);
    return [x + this.unit / 2, y + this.unit / 2];
  }

  #drawCells() {
    const { context: c, unit, scene } = this;
    const floor = parseHex(scene.colours.floor);
    const gap = unit >= 10 ? 1 : 0;
    for (let state = 0; state < this.world.size; state += 1) {
      const place = scene.scale.place(scene.heat[state]);
      let colour = place === null ? floor : viridis(place);
      if (scene.faded) colour = mixColours(colour, floor, 0.6);
      const [x, y] = this.#corner(state);
      c.fillStyle = scene.colours.floor;
      c.fillRect(x, y, unit, unit);
      c.fillStyle = toHex(colour);
      c.fillRect(x, y, unit - gap, unit - gap);
      const known = scene.policy && scene.policy[state] >= 0 && state !== scene.task.goal;
      if (known && unit / this.ratio >= ARROWS_FROM) this.#drawArrow(state, scene.policy[state], inkOn(colour));
    }
  }

  #drawArrow(state, action, ink) {
    const { context: c, unit, scene } = this;
    const [x, y] = this.#centre(state);
    const [down, right] = MOVES[action];
    const at = (along, across) => [
      x + unit * (along * right + across * down),
      y + unit * (along * down + across * right),
    ];
    c.globalAlpha = scene.faded ? 0.95 : 0.72;
    c.fillStyle = ink;
    c.strokeStyle = ink;
    c.beginPath();
    if (unit / this.ratio < 11) {
      c.moveTo(...at(0.32, 0));
      c.lineTo(...at(-0.24, 0.27));
      c.lineTo(...at(-0.24, -0.27));
      c.fill();
    } else {
      c.lineWidth = Math.max(1, 0.08 * unit);
      c.lineCap = "round";
      c.lineJoin = "round";
      c.moveTo(...at(-0.27, 0));
      c.lineTo(...at(0.25, 0));
      c.moveTo(...at(0.05, 0.19));
      c.lineTo(...at(0.27, 0));
      c.lineTo(...at(0.05, -0.19));
      c.stroke();
    }
    c.globalAlpha = 1;
  }

  #text(text, x, y, size, colour, weight = 600) {
    const { context: c } = this;
    c.font = `${weight} ${size}px system-ui, sans-serif`;
    c.fillStyle = colour;
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.fillText(text, x, y + 0.06 * size);
  }

  #drawLetters() {
    const { scene, unit, ratio } = this;
    if (unit / ratio < 9) return;
    for (const [letter, state] of Object.entries(this.world.goals)) {
      if (state === scene.task.goal) continue;
      const [x, y] = this.#centre(state);
      this.context.fillStyle = scene.colours.floor;
      this.context.fillRect(...this.#corner(state), unit, unit);
      this.#text(letter, x, y, 0.7 * unit, scene.colours.muted, 500);
    }
  }

  #drawEnds() {
    const { context: c, scene, ratio } = this;
    const radius = Math.max(0.62 * this.unit, 7.5 * ratio);
    for (const [letter, state] of [["I", scene.task.start], [scene.task.name, scene.task.goal]]) {
      const goal = state === scene.task.goal;
      const [x, y] = this.#centre(state);
      c.beginPath();
      c.arc(x, y, radius, 0, 2 * Math.PI);
      c.fillStyle = goal ? scene.colours.goal : scene.colours.start;
      c.fill();
      c.lineWidth = 2 * ratio;
      c.strokeStyle = scene.colours.paper;
      c.stroke();
      this.#text(letter, x, y, 1.15 * radius, "#ffffff", 700);
    }
  }

  #drawDiamond(state, fill, ink, label) {
    const { context: c, scene, ratio } = this;
    const radius = Math.max(0.72 * this.unit, 8.5 * ratio);
    const [x, y] = this.#centre(state);
    c.beginPath();
    c.moveTo(x, y - radius);
    c.lineTo(x + radius, y);
    c.lineTo(x, y + radius);
    c.lineTo(x - radius, y);
    c.closePath();
    c.fillStyle = fill;
    c.fill();
    c.lineWidth = 1.75 * ratio;
    c.strokeStyle = label === "+" ? ink : scene.colours.paper;
    c.stroke();
    this.#text(label, x, y, 1.05 * radius, ink, 700);
  }

  #drawLine(states, colour, thin) {
    const { context: c, scene, ratio, unit } = this;
    c.beginPath();
    states.forEach((state, i) => (i ? c.lineTo(...this.#centre(state)) : c.moveTo(...this.#centre(state))));
    c.lineJoin = "round";
    c.lineCap = "round";
    const width = Math.min(6 * ratio, Math.max(1.5 * ratio, (thin ? 0.14 : 0.24) * unit));
    for (const [extra, stroke] of [[2 * ratio, scene.colours.paper], [0, colour]]) {
      c.lineWidth = width + extra;
      c.strokeStyle = stroke;
      c.stroke();
    }
  }

  #drawAgent({ state, colour }) {
    const { context: c, scene, ratio } = this;
    const [x, y] = this.#centre(state);
    c.beginPath();
    c.arc(x, y, Math.max(0.45 * this.unit, 5 * ratio), 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.fill();
    c.lineWidth = 2.5 * ratio;
    c.strokeStyle = scene.colours.agentRing;
    c.stroke();
  }

  #drawFrame(state) {
    const { context: c, unit, ratio, scene } = this;
    const [x, y] = this.#corner(state);
    for (const [width, colour] of [[4 * ratio, scene.colours.paper], [2 * ratio, scene.colours.ink]]) {
      c.lineWidth = width;
      c.strokeStyle = colour;
      c.strokeRect(x, y, unit, unit);
    }
  }
}
