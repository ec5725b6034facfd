// Episodes whose path is known before they are played: recorded ones, and those that follow stored policies.

/** An episode; playing it moves `steps`. */
export class Episode {
  /**
   * path: states, the first one included; parts: [candidate, steps] in order, candidate 0 for no guide;
   * outcome: "goal", "limit" (of steps), "loop", "undefined" (no action known) or "cut" (the rest was not recorded).
   */
  constructor(path, parts, outcome) {
    Object.assign(this, { path, parts, outcome, steps: 0 });
  }

  get state() {
    return this.path[this.steps];
  }

  get done() {
    return this.steps >= this.path.length - 1;
  }

  advance(count) {
    this.steps = Math.min(this.path.length - 1, this.steps + count);
  }

  /** Index of the part that the next step belongs to. */
  get part() {
    let end = 0;
    return this.parts.findIndex(([, length]) => (end += length) > this.steps);
  }

  /** How often each of `size` states was entered so far. */
  visits(size) {
    const counts = new Uint32Array(size);
    for (let i = 1; i <= this.steps; i += 1) counts[this.path[i]] += 1;
    return counts;
  }

  /** The states from step `first` on, split where the guide changes: [candidate, states]. */
  trail(first) {
    const runs = [];
    let end = 0;
    for (const [candidate, length] of this.parts) {
      const [from, to] = [Math.max(first, end), Math.min(this.steps, end + length)];
      if (from < to) runs.push([candidate, this.path.slice(from, to + 1)]);
      end += length;
    }
    return runs;
  }
}

/** The first episode of a task as it was run. */
export function recordedEpisode(world, task) {
  const { actions, parts } = task.first;
  const path = [task.start];
  actions.forEach((action, i) => path.push(world.successors[4 * path[i] + action]));
  const length = task.steps[0];
  if (actions.length < length) return new Episode(path, parts, "cut");
  return new Episode(path, parts, task.truncated.includes(0) ? "limit" : "goal");
}

/**
 * Follow a policy until one of the ends, the goal, an undefined state or a state met before.
 * Returns the visited states (the first one included) and why it stopped.
 */
function followPolicy(world, policy, start, goal, end) {
  const path = [start];
  const met = new Set(path);
  let state = start;
  while (true) {
    if (state === goal) return { path, outcome: "goal" };
    if (state === end) return { path, outcome: "end" };
    if (policy[state] < 0) return { path, outcome: "undefined" };
    state = world.successors[4 * state + policy[state]];
    path.push(state);
    if (met.has(state)) return { path, outcome: "loop" };
    met.add(state);
  }
}

/** The greedy policy from the start. */
export function greedyEpisode(world, policy, start, goal) {
  const { path, outcome } = followPolicy(world, policy, start, goal, -1);
  return new Episode(path, [[0, path.length - 1]], outcome);
}

/** Candidate `leader` (a skill, or an earlier policy with subgoal -1) as far as it leads, then the greedy policy. */
export function guidedEpisode(world, leader, guide, policy, start, goal) {
  const lead = followPolicy(world, guide.policy, start, goal, guide.subgoal);
  const guided = [leader, lead.path.length - 1];
  if (lead.outcome === "goal" || lead.outcome === "loop") return new Episode(lead.path, [guided], lead.outcome);
  const { path, outcome } = followPolicy(world, policy, lead.path[guided[1]], goal, -1);
  return new Episode([...lead.path, ...path.slice(1)], [guided, [0, path.length - 1]], outcome);
}
