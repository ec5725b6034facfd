// One method at work: its map, its numbers, its guides, and the episode that is being played.

import { methodColour, skillColour } from "./colour.js";
import { greedyEpisode, guidedEpisode } from "./episodes.js";
import { formatCount, formatNumber } from "./format.js";
import { describeDraws, fillGuides, guideInSentence, guideMark, likeliestGuide, showChances } from "./guides.js";
import { drawChances } from "./charts.js";
import { MapView, describeCell, layerScale, mapAsText } from "./map_view.js";
import { FirstEpisode, randomNumbers } from "./simulation.js";

const LAST = 10; // episodes of the final mean

/** An episode whose path is known, played with the calls of FirstEpisode. */
class KnownEpisode {
  constructor({ path, outcome, guided }) {
    Object.assign(this, { path, outcome, guided, steps: 0 });
  }

  get state() {
    return this.path[this.steps];
  }

  get done() {
    return this.steps >= this.path.length - 1;
  }

  advance(count) {
    this.steps = Math.min(this.path.length - 1, this.steps + count);
    return this.done;
  }
}

/** Mean steps of the last episodes. */
export function finalMean(steps) {
  const last = steps.slice(-LAST);
  return last.reduce((sum, value) => sum + value, 0) / last.length;
}

export function sum(numbers) {
  return numbers.reduce((total, value) => total + value, 0);
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
    this.trail = [];
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
    fillGuides(list, world, task, this.key, this.guide, (candidate) => this.app.update({ [this.key]: candidate }));
    this.detail.querySelector(".none").hidden = task.method.guides !== "none";
    this.detail.querySelector(".unknown").hidden = task.method.guides === "none" || task.chances() !== null;
    this.detail.querySelector(".chances").hidden = task.chances() === null;
    this.showFound();
    this.showText();
  }

  showFacts() {
    const steps = this.task.steps();
    const put = (name, text) => { this.find(`[data-fact=${name}]`).textContent = text; };
    put("first", formatCount(steps[0]));
    put("last", formatNumber(finalMean(steps)));
    put("total", formatCount(sum(steps)));
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
      line.textContent = `Task ${name} then adds a skill to row ${row}, column ${column} (+ on the map).`;
    }
  }

  /** The guide that is shown, or null for the learned policy. */
  get shownGuide() {
    return this.guide > 0 ? this.task.guides[this.guide - 1] : null;
  }

  get shownPolicy() {
    return this.shownGuide ? this.shownGuide.policy : this.task.policy();
  }

  showText() {
    if (!this.task || !this.find(".as-text").open) return;
    const subgoals = this.task.guides.map((guide) => guide.subgoal).filter((state) => state >= 0);
    this.find("pre").textContent = mapAsText(this.environment.world, this.task, this.shownPolicy, subgoals);
  }

  /** What depends on the cursor only. */
  showEpisode() {
    const { episode } = this.settings;
    showChances(this.detail.querySelector(".guides"), this.task, episode);
    this.detail.querySelector(".drawn").textContent = describeDraws(this.task, episode);
    const chances = this.task.chances();
    if (chances) drawChances(this.detail.querySelector(".chances svg"), chances, episode, this.guide);
  }

  describe(state) {
    const { world } = this.environment;
    return describeCell(world, this.task, state, this.shownPolicy, this.app.dataset.actions, this.gamma);
  }

  // -- playing --------------------------------------------------------------------------------------------------

  /** The mode that this method can play. */
  get mode() {
    const { mode } = this.settings;
    if (mode === "first" && this.task.method.episode === "unknown") return "greedy";
    return mode === "guided" && this.leader === 0 ? "greedy" : mode;
  }

  /** Candidate that leads a guided episode. */
  get leader() {
    if (!this.task.guides.length) return 0;
    return this.guide || likeliestGuide(this.task, this.settings.episode);
  }

  /** Make the episode ready at the start. */
  rewind() {
    const { environment, task } = this;
    const { world, parameters } = environment;
    this.trail = [task.start];
    if (this.mode === "first") {
      this.playing = new FirstEpisode({
        world,
        parameters,
        start: task.start,
        goal: task.goal,
        kind: task.method.episode,
        guides: task.guides,
        chances: task.chances()?.[0],
        initial: task.initial(),
        random: randomNumbers(this.settings.draw),
      });
      return;
    }
    const policy = task.policy();
    this.playing = new KnownEpisode(
      this.mode === "guided"
        ? guidedEpisode(world, task.guides[this.leader - 1], policy, task.start, task.goal)
        : greedyEpisode(world, policy, task.start, task.goal),
    );
  }

  /** Go on by some steps; returns whether the episode is over. */
  advance(count) {
    const { playing } = this;
    if (playing instanceof KnownEpisode) {
      playing.advance(count);
      this.trail = playing.path.slice(0, playing.steps + 1);
    } else {
      // The trail wants the last steps one by one, the rest may go at once.
      const single = Math.min(count, 100);
      if (count > single) {
        playing.advance(count - single);
        this.trail = [playing.state];
      }
      for (let i = 0; i < single && !playing.done; i += 1) {
        playing.advance(1);
        this.trail.push(playing.state);
      }
      this.trail = this.trail.slice(-100);
    }
    return playing.done;
  }

  /** The state of the played episode in words. */
  describeEpisode() {
    const { playing, task } = this;
    const steps = `${formatCount(playing.steps)} ${playing.steps === 1 ? "step" : "steps"}`;
    const shortest = task.distances()[task.start];
    if (playing.path?.length === 1) return "Nothing is known at the start yet: the learned policy says no action.";
    if (playing.steps === 0) return this.describeStart();
    if (playing.state === task.goal) return `Goal ${task.name} after ${steps}; the shortest path has ${shortest}.`;
    if (!playing.done) return `${steps}${this.describeLead()}`;
    if (playing.outcome === "loop") return `Goes round in circles after ${steps}: not yet a way to the goal.`;
    if (playing.outcome === "undefined") return `Stops after ${steps}, where nothing is known yet.`;
    return `Step limit reached after ${steps}.`;
  }

  describeStart() {
    const { task } = this;
    if (this.mode === "guided") {
      return `Ready: ${guideInSentence(task, this.leader)}, then the learned policy.`;
    }
    if (this.mode === "greedy") {
      return this.settings.mode === "first"
        ? "Ready: the learned policy (how this method explores is not known to this page)."
        : "Ready: the learned policy.";
    }
    if (task.initial()) return "Ready: starts from what the task before has learned.";
    return this.task.guides.length ? "Ready: nothing known of this goal, but guided." : "Ready: nothing known yet.";
  }

  describeLead() {
    const { playing, task } = this;
    if (playing instanceof KnownEpisode) {
      return playing.steps < playing.guided ? `, led by ${guideInSentence(task, this.leader)}` : "";
    }
    const drawn = playing.drawn;
    if (!drawn.length) return ", exploring";
    const name = guideInSentence(task, drawn[drawn.length - 1]);
    return playing.guide ? `, led by ${name}` : `, exploring after ${name}`;
  }

  // -- drawing --------------------------------------------------------------------------------------------------

  /** Whether the colours show visits at this moment. */
  get showsVisits() {
    return this.playing instanceof FirstEpisode && this.playing.steps > 0;
  }

  get layer() {
    return this.showsVisits ? "visits" : this.settings.layer;
  }

  draw() {
    const { environment, task, app, playing } = this;
    const { world } = environment;
    const holder = this.find(".map-holder");
    const cell = this.view.fit(world, holder.clientWidth, app.tallestMap(world), app.zoomed);
    this.find(".zoom-hint").hidden = cell >= 9 && !app.zoomed;
    const begun = playing.steps > 0;
    const heat = { visits: () => playing.visits, metric: task.metric, value: task.value }[this.layer]();
    const lead = playing instanceof KnownEpisode ? playing.guided : 0;
    this.view.draw({
      task,
      heat,
      scale: layerScale(this.layer, this.gamma),
      colours: { ...app.colours, method: this.colour },
      faded: this.guide > 0 && !this.showsVisits,
      policy: this.showsVisits && !this.guide ? null : this.shownPolicy,
      markers: task.guides
        .map((guide, i) => ({ state: guide.subgoal, candidate: i + 1, label: guideMark(task, i + 1) }))
        .filter(({ state }) => state >= 0),
      found: task.method.guides === "skills" ? task.subgoal : -1,
      trail: begun && {
        states: this.trail,
        guided: lead,
        thin: this.showsVisits,
        colour: this.colour,
        guideColour: this.leader ? skillColour(this.leader) : this.colour,
      },
      agent: begun ? playing.state : -1,
      inspected: app.inspected,
    });
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
