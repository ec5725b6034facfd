// Holds the view, wires the controls to it and keeps the clock of the playback.

import { readAddress, writeAddress } from "./address.js";
import { methodColour, toHex, viridis } from "./colour.js";
import { MARGIN, drawCurves, followPointer } from "./charts.js";
import { openDataset, unpack } from "./dataset.js";
import { formatCount, formatFactor, formatNumber } from "./format.js";
import { layerScale } from "./map_view.js";
import { Stage, finalMean, sum } from "./stage.js";
import { byId, html } from "./svg.js";
import { MOVES } from "./world.js";

const SPEEDS = [2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000]; // steps a second
const USUAL_SPEED = { first: 500, guided: 20, greedy: 20 };
const WIDE = 4; // maps this many times wider than high stand one above the other

const EXPLANATIONS = {
  first: "The first episode of the task as it was run. Colour shows how often each cell was entered. One episode is luck: look at other seeds.",
  guided: "The skill or earlier policy chosen below (or the likeliest one at the cursor) leads as far as it can, then the policy learned for this task takes over.",
  greedy: "The policy learned by the last episode, without random actions.",
};

class App {
  constructor(raw) {
    this.dataset = openDataset(raw);
    this.inspected = -1;
    this.zoomed = false;
    this.running = false;
    this.owed = 0; // steps that the clock has not paid out yet
    this.systemDark = window.matchMedia("(prefers-color-scheme: dark)");
    const find = (id) => byId(id);
    this.stages = [
      new Stage(find("stage1"), find("detail1"), "guide", this),
      new Stage(find("stage2"), find("detail2"), "guide2", this),
    ];
    this.fillOnce();
    this.listen();
    this.setView(readAddress(window.location.hash, this.dataset));
  }

  get environment() {
    return this.dataset.environments.find(({ name }) => name === this.view.environment);
  }

  get shown() {
    return this.view.compare ? this.stages : this.stages.slice(0, 1);
  }

  get dark() {
    return this.view.theme ? this.view.theme === "dark" : this.systemDark.matches;
  }

  tallestMap(world) {
    const beside = this.view.compare && world.columns / world.rows > WIDE ? 0.4 : 0.66;
    return Math.max(230, beside * window.innerHeight);
  }

  // -- the view ---------------------------------------------------------------------------------------------------

  /** Change parts of the view; what no longer fits is set right by `readAddress`. */
  update(changes) {
    const next = { ...this.view, ...changes };
    if ("environment" in changes) this.inspected = -1;
    if (["environment", "task", "method", "seed"].some((key) => key in changes)) next.guide = 0;
    if (["environment", "task", "with", "seed"].some((key) => key in changes)) next.guide2 = 0;
    this.setView(readAddress(writeAddress(next), this.dataset));
    this.announce(this.summary());
  }

  setView(view) {
    const modeChanged = this.view?.mode !== view.mode;
    this.view = view;
    this.remember();
    this.stop();
    this.applyTheme();
    if (modeChanged) this.setSpeed(USUAL_SPEED[view.mode]);
    const { environment } = this;
    const names = [view.method, view.with];
    this.shown.forEach((stage, i) => stage.show(environment, environment.task(names[i], view.seed, view.task), view));
    this.showControls();
    this.showFinding();
    this.showEpisode();
    this.rewind();
  }

  remember() {
    // Inside a report the page may sit in a frame without an address of its own; there is nothing to share then.
    if (/^(file|https?):$/.test(window.location.protocol)) {
      window.history.replaceState(null, "", writeAddress(this.view));
    }
  }

  moveCursor(episode) {
    const view = readAddress(writeAddress({ ...this.view, episode }), this.dataset);
    if (view.episode === this.view.episode) return;
    this.view = view;
    for (const stage of this.shown) stage.settings = view;
    this.remember();
    this.showEpisode();
    if (view.mode === "guided") {
      this.stop();
      this.rewind();
    }
  }

  announce(text) {
    byId("status").textContent = text;
  }

  summary() {
    const { view } = this;
    const parts = this.shown.map(({ task }) =>
      `${task.method.label}: first episode ${formatCount(task.steps[0])} steps,` +
      ` last ${this.dataset.window} ${formatNumber(finalMean(task.steps, this.dataset.window))} on average.`);
    return `${this.environment.title}, task ${view.task}, seed ${view.seed}. ${parts.join(" ")}`;
  }

  applyTheme() {
    document.documentElement.dataset.theme = this.dark ? "dark" : "light";
    byId("theme").textContent = this.dark ? "Light" : "Dark";
    byId("theme").setAttribute("aria-label", `Switch to ${this.dark ? "light" : "dark"} colours`);
    const style = getComputedStyle(document.documentElement);
    const names = ["floor", "wall", "ink", "paper", "muted", "start", "goal"];
    this.colours = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
    this.colours.agentRing = "#ffffff";
  }

  // -- controls ---------------------------------------------------------------------------------------------------

  fillOnce() {
    const { environments } = this.dataset;
    byId("environment").replaceChildren(
      ...environments.map(({ name, title }) => html("option", { value: name }, title)));
    for (const element of document.querySelectorAll(".window")) element.textContent = String(this.dataset.window);
    byId("speed").max = String(SPEEDS.length - 1);
    // The thumb, 16 pixels wide, stands under the line of the cursor.
    byId("cursor").style.marginLeft = `${MARGIN.left - 8}px`;
    byId("cursor").style.width = `calc(100% - ${MARGIN.left + MARGIN.right - 16}px)`;
  }

  showControls() {
    const { view, environment } = this;
    byId("environment").value = view.environment;
    byId("seed").replaceChildren(...environment.seeds.map((seed) => html("option", { value: seed }, String(seed))));
    byId("seed").value = String(view.seed);
    byId("tasks").replaceChildren(...environment.tasks.map((letter) => this.radio("task", letter, letter)));
    byId("layer").value = view.layer;
    byId("layer-field").hidden = view.mode === "first"; // its colours are visits
    byId("compare").checked = view.compare;
    byId("compare").disabled = environment.methods.length < 2;
    byId("compare-note").hidden = environment.methods.length > 1;
    for (const input of document.querySelectorAll("input[name=mode]")) input.checked = input.value === view.mode;
    this.fillMethods(this.stages[0], environment.methods, view.method);
    const others = environment.methods.filter((name) => name !== view.method);
    if (view.compare) this.fillMethods(this.stages[1], others, view.with);
    for (const element of [this.stages[1].section, this.stages[1].detail]) element.hidden = !view.compare;
    const { columns, rows } = environment.world;
    const board = byId("board");
    board.classList.toggle("compare", view.compare);
    board.classList.toggle("wide", columns / rows > WIDE);
    byId("explanation").textContent = EXPLANATIONS[view.mode];
    this.showGoals();
    this.showSource();
  }

  /** The goals in the order in which they are learned. */
  showGoals() {
    const [first, ...others] = this.environment.tasks;
    const last = others.pop();
    byId("first-goal").textContent = first;
    byId("next-goals").textContent = last ? `, then ${others.length ? `${others.join(", ")} and ` : ""}${last}` : "";
  }

  radio(name, value, text) {
    const input = html("input", { type: "radio", name, value });
    input.checked = this.view[name] === value;
    return html("label", {}, input, html("span", {}, text));
  }

  fillMethods(stage, methods, chosen) {
    const select = stage.find("select");
    const label = (name) => this.environment.task(name, this.view.seed, this.view.task).method.label;
    select.replaceChildren(...methods.map((name) => html("option", { value: name }, label(name))));
    select.value = chosen;
  }

  showSource() {
    const { learning } = this.environment.parameters;
    byId("source").textContent =
      `${this.environment.title}: α ${learning.alpha}, γ ${learning.gamma}, ε ${learning.epsilon},` +
      ` ${formatCount(learning.episodes)} episodes a task; seeds ${this.environment.seeds.join(", ")} of the run.`;
  }

  /** The one sentence to take away. */
  showFinding() {
    const [first, second] = this.shown.map(({ task }) => task);
    const last = this.dataset.window;
    const strong = (text) => html("b", {}, text);
    const count = first.steps.length;
    const total = (task) => sum(task.steps);
    if (!second) {
      byId("finding").replaceChildren(
        strong(first.method.label), ` took ${formatCount(first.steps[0])} steps in its first episode and `,
        strong(formatNumber(finalMean(first.steps, last))), ` on average in its last ${last}; the shortest path has `,
        strong(String(first.distances[first.start])), ".");
      return;
    }
    if (this.view.task === this.environment.tasks[0]) {
      byId("finding").replaceChildren(
        `Task ${this.view.task} is the first, so nothing is transferred yet: any difference between the methods is luck`,
        " or their exploration.");
      return;
    }
    const [less, more] = total(first) <= total(second) ? [first, second] : [second, first];
    byId("finding").replaceChildren(
      `Over ${formatCount(count)} episodes of task ${this.view.task} `,
      strong(less.method.label), ` took ${formatCount(total(less))} steps, ${more.method.label} ${formatCount(total(more))}: `,
      strong(`${formatFactor(total(more), total(less))} times as many`), ".");
  }

  /** What moves with the cursor. */
  showEpisode() {
    const { episode } = this.view;
    const records = this.shown.map(({ task }) => task);
    const series = records.map((task) => ({
      label: task.method.label,
      colour: methodColour(task.method.colour, this.dark),
      steps: task.steps,
    }));
    const cursor = byId("cursor");
    cursor.max = String(Math.max(...series.map(({ steps }) => steps.length)));
    cursor.value = String(episode);
    const words = series.map(({ label, steps }) => `${label} ${formatCount(steps[episode - 1])} steps`).join(", ");
    cursor.setAttribute("aria-valuetext", `Episode ${episode}: ${words}`);
    byId("episode").textContent = String(episode);
    byId("curve-values").replaceChildren(...series.map(({ label, colour, steps }) => {
      const swatch = html("span", { class: "swatch" });
      swatch.style.background = colour;
      const value = html("b", { "data-steps": steps[episode - 1] }, `${formatCount(steps[episode - 1])} steps`);
      return html("li", {}, swatch, `${label} `, value);
    }));
    drawCurves(byId("curve"), series, this.dataset.window, records[0].distances[records[0].start], episode);
    for (const stage of this.shown) stage.showEpisode();
  }

  // -- playback ---------------------------------------------------------------------------------------------------

  setSpeed(speed) {
    byId("speed").value = String(SPEEDS.indexOf(speed));
    this.showSpeed();
  }

  get speed() {
    return SPEEDS[Number(byId("speed").value)];
  }

  showSpeed() {
    const text = `${formatCount(this.speed)} steps per second`;
    byId("speed").setAttribute("aria-valuetext", text);
    byId("speed-text").textContent = `${formatCount(this.speed)} steps/s`;
  }

  rewind() {
    for (const stage of this.shown) stage.rewind();
    this.showPlayer();
    this.draw();
  }

  get over() {
    return this.shown.every(({ playing }) => playing.done);
  }

  toggle() {
    if (this.running) {
      this.stop();
      this.announce(this.describeEpisodes());
      return;
    }
    if (this.over) this.rewind();
    this.running = true;
    this.owed = 0;
    this.last = performance.now();
    this.showPlayer();
    this.request = requestAnimationFrame((now) => this.tick(now));
  }

  stop() {
    cancelAnimationFrame(this.request);
    this.running = false;
    this.showPlayer();
  }

  tick(now) {
    this.owed += (Math.min(100, now - this.last) / 1000) * this.speed;
    this.last = now;
    const steps = Math.floor(this.owed);
    this.owed -= steps;
    if (steps > 0) this.advance(steps);
    if (this.running) this.request = requestAnimationFrame((later) => this.tick(later));
  }

  advance(steps) {
    for (const stage of this.shown) if (!stage.playing.done) stage.advance(steps);
    if (this.over) {
      this.stop();
      this.announce(this.describeEpisodes());
    }
    this.draw();
  }

  describeEpisodes() {
    return this.shown.map((stage) => `${stage.task.method.label}: ${stage.describeEpisode()}`).join(" ");
  }

  showPlayer() {
    const play = byId("play");
    play.textContent = this.running ? "Pause" : "Play";
    play.classList.toggle("running", this.running);
  }

  draw() {
    for (const stage of this.shown) stage.draw();
    this.showLegend();
  }

  showLegend() {
    const layer = this.shown[0].layer;
    const scale = layerScale(layer, this.shown[0].gamma);
    if (this.legendOf === scale.title) return;
    this.legendOf = scale.title;
    byId("legend-title").textContent = scale.title;
    const stops = Array.from({ length: 17 }, (_, i) => toHex(viridis(i / 16)));
    byId("legend-bar").style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    byId("legend-ticks").replaceChildren(...scale.ticks.map(([place, text]) => {
      const tick = html("span", {}, text);
      tick.style.left = `${100 * place}%`;
      if (place === 0) tick.className = "first";
      if (place === 1) tick.className = "last";
      return tick;
    }));
  }

  // -- events -----------------------------------------------------------------------------------------------------

  listen() {
    const on = (id, event, act) => byId(id).addEventListener(event, act);
    on("environment", "change", (event) => this.update({ environment: event.target.value }));
    on("seed", "change", (event) => this.update({ seed: event.target.value }));
    on("tasks", "change", (event) => {
      this.update({ task: event.target.value });
      byId("tasks").querySelector("input:checked").focus();
    });
    on("layer", "change", (event) => this.update({ layer: event.target.value }));
    on("compare", "change", (event) => this.update({ compare: event.target.checked }));
    on("modes", "change", (event) => this.update({ mode: event.target.value }));
    on("cursor", "input", (event) => this.moveCursor(Number(event.target.value)));
    on("speed", "input", () => this.showSpeed());
    on("play", "click", () => this.toggle());
    on("step", "click", () => {
      this.stop();
      this.advance(1);
    });
    on("restart", "click", () => {
      this.stop();
      this.rewind();
    });
    on("finish", "click", () => {
      this.stop();
      this.advance(Infinity);
    });
    on("theme", "click", () => this.update({ theme: this.dark ? "light" : "dark" }));
    on("zoom", "change", (event) => {
      this.zoomed = event.target.checked;
      this.draw();
    });
    this.stages.forEach((stage, i) => {
      stage.find("select").addEventListener("change", (event) =>
        this.update({ [i ? "with" : "method"]: event.target.value }));
      this.listenToMap(stage);
      followPointer(stage.detail.querySelector(".chances svg"), () => this.episodes, (episode) => this.moveCursor(episode));
    });
    followPointer(byId("curve"), () => this.episodes, (episode) => this.moveCursor(episode));
    document.addEventListener("keydown", (event) => this.onKey(event));
    window.addEventListener("hashchange", () => this.setView(readAddress(window.location.hash, this.dataset)));
    this.systemDark.addEventListener("change", () => this.setView(this.view));
    let drawn = byId("board").clientWidth;
    new ResizeObserver(([entry]) => {
      if (Math.round(entry.contentRect.width) === drawn || !this.view) return;
      drawn = Math.round(entry.contentRect.width);
      this.showEpisode();
      this.draw();
    }).observe(byId("board"));
  }

  get episodes() {
    return this.stages[0].task.steps.length;
  }

  listenToMap(stage) {
    const canvas = stage.find("canvas");
    const inspect = (state) => {
      if (state === this.inspected) return;
      this.inspected = state;
      this.draw();
    };
    canvas.addEventListener("pointermove", (event) => inspect(stage.view.stateUnder(event)));
    canvas.addEventListener("pointerdown", (event) => inspect(stage.view.stateUnder(event)));
    canvas.addEventListener("pointerleave", () => document.activeElement !== canvas && inspect(-1));
    canvas.addEventListener("focus", () => {
      if (this.inspected < 0) inspect(stage.task.start);
      this.announce(stage.describe(this.inspected));
    });
    canvas.addEventListener("blur", () => inspect(-1));
    canvas.addEventListener("keydown", (event) => {
      const action = ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"].indexOf(event.key);
      if (action < 0 || this.inspected < 0) return;
      event.preventDefault();
      inspect(this.cellBeyond(this.inspected, MOVES[action]));
      this.announce(stage.describe(this.inspected));
    });
  }

  /** The next free cell in a direction, walls left out; the same cell at the edge. */
  cellBeyond(state, [down, right]) {
    const { rows, columns, cells, stateAt } = this.environment.world;
    let [row, column] = cells[state];
    while (true) {
      row += down;
      column += right;
      if (row < 0 || column < 0 || row >= rows || column >= columns) return state;
      const next = stateAt[row * columns + column];
      if (next >= 0) return next;
    }
  }

  /** Keys for the whole page, unless a control has them. */
  onKey(event) {
    if (event.target.closest("input, select, button, summary, canvas") || event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    const step = { ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10 }[event.key];
    if (step) this.moveCursor(Math.max(1, this.view.episode + step));
    else if (event.key === " ") this.toggle();
    else return;
    event.preventDefault();
  }
}

unpack(byId("data").textContent).then((raw) => new App(raw), () => {
  byId("finding").textContent = "This page needs a browser that unpacks gzip (DecompressionStream), any from 2023 on.";
});
