// Episodes that follow stored policies: no chance in them, so they are worked out in full before they are shown.

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

/** The greedy policy from the start: outcome "goal", "undefined" or "loop". */
export function greedyEpisode(world, policy, start, goal) {
  const { path, outcome } = followPolicy(world, policy, start, goal, -1);
  return { path, outcome, guided: 0 };
}

/**
 * A guide (a skill with its subgoal, or an earlier policy with subgoal -1) as far as it leads, then the greedy policy.
 * `guided` is the number of steps taken under the guide.
 */
export function guidedEpisode(world, guide, policy, start, goal) {
  const lead = followPolicy(world, guide.policy, start, goal, guide.subgoal);
  const guided = lead.path.length - 1;
  if (lead.outcome === "goal" || lead.outcome === "loop") return { ...lead, guided };
  const rest = followPolicy(world, policy, lead.path[guided], goal, -1);
  return { path: [...lead.path, ...rest.path.slice(1)], outcome: rest.outcome, guided };
}
