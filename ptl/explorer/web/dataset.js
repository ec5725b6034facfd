// The data set with its arrays unpacked when they are first asked for.

import { decodeActions, decodeShareRows, decodeShares, decodeValues, decodeVarints } from "./decode.js";
import { distancesTo, parseWorld } from "./world.js";

/** Run `make` at the first call and remember what it returned. */
function once(make) {
  let made;
  let value;
  return () => {
    if (!made) {
      value = make();
      made = true;
    }
    return value;
  };
}

function splitDraws(counted) {
  const draws = [];
  for (let i = 0; i < counted.length; i += 1 + counted[i]) draws.push(counted.slice(i + 1, i + 1 + counted[i]));
  return draws;
}

function openTask(world, raw) {
  const chances = once(() => {
    if (raw.chances === null) return null;
    return decodeShareRows(raw.chances).map((row) => {
      const sum = row.reduce((total, share) => total + share, 0); // rounding leaves it some 1e-5 off
      return row.map((share) => share / sum);
    });
  });
  const task = {
    ...raw,
    steps: once(() => decodeVarints(raw.steps)),
    value: once(() => decodeValues(raw.value)),
    policy: once(() => decodeActions(raw.policy, world.size)),
    metric: once(() => decodeShares(raw.metric)),
    drawn: once(() => splitDraws(decodeVarints(raw.drawn))),
    initial: once(() => (raw.initial === null ? null : decodeValues(raw.initial))),
    distances: once(() => distancesTo(world, raw.goal)),
    chances,
  };
  return task;
}

/** What can lead the agent in a task: the skills known by then, or the policies of all earlier tasks. */
function guidesOf(run, method, index) {
  if (method.guides === "skills") {
    return run.skills.filter((skill) => skill.after < index).map((skill) => ({
      subgoal: skill.subgoal,
      policy: skill.policy(),
      from: run.tasks[skill.after].name,
    }));
  }
  if (method.guides === "policies") {
    return run.tasks.slice(0, index).map((task) => ({ subgoal: -1, policy: task.policy(), from: task.name }));
  }
  return [];
}

/** The environments by name; each has world, methods, seeds and task(method, seed, letter). */
export function openDataset(raw) {
  const environments = raw.environments.map((entry) => {
    const world = parseWorld(entry.map);
    const runs = new Map();
    const openRun = (name) => {
      if (!runs.has(name)) {
        const run = entry.runs[name];
        runs.set(name, {
          skills: run.skills.map((skill) => ({ ...skill, policy: once(() => decodeActions(skill.policy, world.size)) })),
          tasks: run.tasks.map((task) => openTask(world, task)),
        });
      }
      return runs.get(name);
    };
    return {
      ...entry,
      world,
      /** One method's record of one task, with its guides and the method itself. */
      task(method, seed, letter) {
        const run = openRun(`${method}/${seed}`);
        const index = entry.tasks.indexOf(letter);
        const kind = { id: method, ...raw.methods[method] };
        return { ...run.tasks[index], method: kind, guides: guidesOf(run, kind, index) };
      },
    };
  });
  return { environments, actions: raw.actions };
}
