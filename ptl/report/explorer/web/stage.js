// One method at work: its map, its numbers, its guides, and the episode that is being played.

import { methodColour, skillColour } from "./colour.js";
import { greedyEpisode, guidedEpisode, recordedEpisode } from "./episodes.js";
import { formatCount, formatNumber, formatPercent } from "./format.js";
import { describeDraws, fillGuides, guideInSentence, guideMark, likeliestGuide, showChances } from "./guides.js";
import { drawChances } from "./charts.js";
import { MapView, describeCell, describeVisits, layerScale, mapAsText } from "./map_view.js";

const TRAIL = 60; // steps of the trail of a first episode

export function sum(numbers) {
  return numbers.reduce((total, value) => total + value, 0);
}

/** Mean steps of the last episodes. */
export function finalMean(steps, window) {
  const last = steps.slice(-window);
  return sum(last) / last.length;
}

export class Stage {
  /** section, detail: elements of the map and of the guides; key: name of the guide in the address. */
  constructor(section, detail, key, app) {
    this.section = section;
    this.detail = detail;
    this.key = key;
    this.app = app;
    this.find = (selector) => section.querySelector(selector);
    this.view = new MapView(this.find("canvas"));
    this.find(".as-text").addEventListener("toggle", () => this.showText());
  }

  /** Show a task's record; everything else follows from it and the app's view. */
  show(environment, task, view) {
    Object.assign(this, { environment, task, settings: view, guide: view[this.key] });
    const { world } = environment;
    this.gamma = environment.parameters.learning.gamma;
    this.colour = methodColour(task.method.colour, this.app.dark);
    for (const element of [this.section, this.detail]) element.style.setProperty("--method", this.colour);
    this.showFacts();
    const canvas = this.find("canvas");
    canvas.setAttribute(
      "aria-label",
      `Map of ${environment.title}, ${world.rows} rows, ${world.columns} columns, task ${task.name},` +
        ` ${task.method.label}. Arrow keys move over the cells.`,
    );
    const keeps = { skills: "skills", policies: "earlier policies", none: "no skills" }[task.method.guides];
    this.detail.querySelector("h3").textContent = `${task.method.label}: ${keeps}`;
    const list = this.detail.querySelector(".guides");
    const choose = (candidate) => this.app.update({ [this.key]: candidate });
    fillGuides(list, world, task, this.mode, this.key, this.guide, choose);
    this.detail.querySelector(".none").hidden = task.method.guides !== "none";
    this.detail.querySelector(".unknown").hidden = task.method.guides === "none" || task.chances !== null;
    this.detail.querySelector(".chances").hidden = task.chances === null;
    this.showFound();
  }

  showFacts() {
    const { steps } = this.task;
    const { window } = this.app.dataset;
    const put = (name, text) => { this.find(`[data-fact=${name}]`).textContent = text; };
    put("first", formatCount(steps[0]));
    put("last", formatNumber(finalMean(steps, window)));
    put("total", formatCount(sum(steps)));
    this.find("dt.last").textContent = `Last ${window}, mean`;
    this.find(".episodes").textContent = `All ${steps.length} episodes`;
    const capped = this.task.truncated.length;
    this.find(".capped").textContent = capped ? `${capped} ended at the step limit` : "";
  }

  showFound() {
    const { world } = this.environment;
    const line = this.detail.querySelector(".found");
    const { subgoal, name, reason, method } = this.task;
    if (method.guides !== "skills") line.textContent = "";
    else if (subgoal < 0) line.textContent = `Task ${name} added no skill: ${reason}.`;
    else {
      const [row, column] = world.cells[subgoal];
      const shown = this.mode === "first" ? "" : " (+ on the map)";
      line.textContent = `Task ${name} then adds a skill to row ${row}, column ${column}${shown}.`;
    }
  }

  /** The guide that is shown, or null for the learned policy. */
  get shownGuide() {
    return this.guide > 0 ? this.task.guides[this.guide - 1] : null;
  }

  /** The policy whose arrows are shown; null in a first episode without a chosen guide, which knows none yet. */
  get shownPolicy() {
    if (this.shownGuide) return this.shownGuide.policy;
    return this.mode === "first" ? null : this.task.policy;
  }

  get visits() {
    return this.playing.visits(this.environment.world.size);
  }

  showText() {
    if (!this.task || !this.find(".as-text").open) return;
    const subgoals = this.task.guides.map((guide) => guide.subgoal).filter((state) => state >= 0);
    const { shownPolicy: policy, visits } = this;
    const sign = policy
      ? (state) => (policy[state] < 0 ? "·" : "↑↓←→"[policy[state]])
      : (state) => (visits[state] ? "o" : "·");
    this.find("pre").textContent = mapAsText(this.environment.world, this.task, sign, subgoals);
  }

  /** What depends on the cursor only. */
  showEpisode() {
    const { episode } = this.settings;
    showChances(this.detail.querySelector(".guides"), this.task, episode);
    this.detail.querySelector(".drawn").textContent = describeDraws(this.task, episode);
    const { chances } = this.task;
    if (chances) drawChances(this.detail.querySelector(".chances svg"), chances, episode, this.guide);
  }

  describe(state) {
    const { task, shownPolicy: policy, environment: { world }, app: { dataset: { actions } } } = this;
    return this.mode === "first"
      ? describeVisits(world, task, state, this.visits[state], policy, actions)
      : describeCell(world, task, state, policy, actions, this.gamma);
  }

  // -- playing --------------------------------------------------------------------------------------------------

  /** The mode that is played: without anything to lead, a guided episode is one of the learned policy. */
  get mode() {
    const { mode } = this.settings;
    return mode === "guided" && this.leader === 0 ? "greedy" : mode;
  }

  /** Candidate that leads a guided episode. */
  get leader() {
    if (!this.task.guides.length) return 0;
    return this.guide || likeliestGuide(this.task, this.settings.episode);
  }

  /** Make the episode ready at the start. */
  rewind() {
    const { environment: { world }, task, leader } = this;
    const { policy, start, goal } = task;
    this.playing = {
      first: () => recordedEpisode(world, task),
      guided: () => guidedEpisode(world, leader, task.guides[leader - 1], policy, start, goal),
      greedy: () => greedyEpisode(world, policy, start, goal),
    }[this.mode]();
  }

  advance(count) {
    this.playing.advance(count);
  }

  /** The state of the played episode in words. */
  describeEpisode() {
    const { playing, task } = this;
    const steps = `${formatCount(playing.steps)} ${playing.steps === 1 ? "step" : "steps"}`;
    const shortest = task.distances[task.start];
    if (playing.path.length === 1) return "Nothing is known at the start yet: the learned policy says no action.";
    if (playing.steps === 0) return this.describeStart();
    if (playing.state === task.goal) return `Goal ${task.name} after ${steps}; the shortest path has ${shortest}.`;
    if (!playing.done) return `${steps}${this.describeLead()}`;
    return {
      loop: `Goes round in circles after ${steps}: not yet a way to the goal.`,
      undefined: `Stops after ${steps}, where nothing is known yet.`,
      limit: `Step limit reached after ${steps}.`,
      cut: `${this.describeCut()}.`,
    }[playing.outcome];
  }

  describeCut() {
    const { playing, task } = this;
    return `First ${formatCount(playing.path.length - 1)} of ${formatCount(task.steps[0])} steps recorded`;
  }

  describeStart() {
    const { task, playing } = this;
    if (this.mode === "guided") return `Ready: ${guideInSentence(task, this.leader)}, then the learned policy.`;
    if (this.mode === "greedy") return "Ready: the learned policy.";
    const cut = playing.outcome === "cut" ? ` ${this.describeCut()}.` : "";
    if (task.first.informed) return `Ready: starts from the values of the task before.${cut}`;
    const guided = { skills: "; skills can guide", policies: "; earlier policies can guide", none: "" };
    return `Ready: no value is learned yet for goal ${task.name}${task.guides.length ? guided[task.method.guides] : ""}.${cut}`;
  }

  /** Who chooses the next step, as the end of a sentence. */
  describeLead() {
    const { playing: { parts, part, steps }, task, mode } = this;
    const [candidate] = parts[part];
    if (mode === "first" && task.method.guides === "policies") return this.describeReuse(candidate, steps);
    if (candidate !== 0) return `, led by ${guideInSentence(task, candidate)}`;
    if (mode !== "first") return "";
    const before = part > 0 ? parts[part - 1][0] : 0;
    return before === 0 ? ", exploring" : `, exploring after ${guideInSentence(task, before)}`;
  }

  /** Policy reuse mixes: psi is the probability of the next action being the earlier policy's. */
  describeReuse(candidate, steps) {
    const { psi, psi_decay: decay } = this.environment.parameters.policy_reuse;
    const name = guideInSentence(this.task, candidate);
    return candidate === 0
      ? `, following the ${name}`
      : `, following the ${name} with probability ${formatPercent(psi * decay ** steps)}`;
  }

  // -- drawing --------------------------------------------------------------------------------------------------

  get layer() {
    return this.mode === "first" ? "visits" : this.settings.layer;
  }

  /** A skill or earlier policy shows its own colour while it leads; pi-reuse mixes and shows the method's. */
  colourOf(candidate) {
    const mixed = this.mode === "first" && this.task.method.guides === "policies";
    return candidate > 0 && !mixed ? skillColour(candidate) : this.colour;
  }

  draw() {
    const { environment: { world }, task, app, playing } = this;
    const holder = this.find(".map-holder");
    const cell = this.view.fit(world, holder.clientWidth, app.tallestMap(world), app.zoomed);
    this.find(".zoom-hint").hidden = cell >= 9 && !app.zoomed;
    const first = this.mode === "first";
    const begun = playing.steps > 0;
    const trail = playing.trail(first ? playing.steps - TRAIL : 0)
      .map(([candidate, states]) => ({ states, colour: this.colourOf(candidate) }));
    this.view.draw({
      task,
      heat: { visits: () => this.visits, metric: () => task.metric, value: () => task.value }[this.layer](),
      scale: layerScale(this.layer, this.gamma),
      colours: app.colours,
      faded: this.guide > 0 && !first,
      policy: this.shownPolicy,
      markers: task.guides
        .map((guide, i) => ({ state: guide.subgoal, candidate: i + 1, label: guideMark(task, i + 1) }))
        .filter(({ state }) => state >= 0),
      found: task.method.guides === "skills" && !first ? task.subgoal : -1, // unknown in a first episode
      trail,
      thin: first,
      agent: begun && { state: playing.state, colour: trail[trail.length - 1].colour },
      inspected: app.inspected,
    });
    this.showText();
    this.find(".outcome").textContent = this.describeEpisode();
    this.find(".cell").textContent = app.inspected >= 0 ? this.describe(app.inspected) : "";
    if (begun && app.zoomed) this.keepInSight(playing.state, cell);
  }

  keepInSight(state, cell) {
    const holder = this.find(".map-holder");
    const x = this.environment.world.cells[state][1] * cell;
    if (x < holder.scrollLeft + 40 || x > holder.scrollLeft + holder.clientWidth - 40) {
      holder.scrollLeft = x - holder.clientWidth / 2;
    }
  }
}
