// The data set of ptl/report/explorer/data.py, unpacked and joined.

import { distancesTo, parseWorld } from "./world.js";

/** The data set from its gzipped JSON in base64. */
export async function unpack(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
}

function openTask(world, raw, readActions) {
  return {
    ...raw,
    value: raw.log10_value.map((exponent) => (exponent === null ? 0 : 10 ** exponent)),
    policy: readActions(raw.policy),
    first: { ...raw.first, actions: readActions(raw.first.actions) },
    distances: distancesTo(world, raw.goal),
  };
}

function openRun(world, raw, readActions) {
  return {
    skills: raw.skills.map((skill) => ({ ...skill, policy: readActions(skill.policy) })),
    tasks: raw.tasks.map((task) => openTask(world, task, readActions)),
  };
}

/** What can lead the agent in a task: the skills known by then, or the policies of all earlier tasks. */
function guidesOf(run, method, index) {
  if (method.guides === "skills") {
    return run.skills
      .filter((skill) => skill.after < index)
      .map(({ subgoal, policy, after }) => ({ subgoal, policy, from: run.tasks[after].name }));
  }
  if (method.guides === "policies") {
    return run.tasks.slice(0, index).map(({ name, policy }) => ({ subgoal: -1, policy, from: name }));
  }
  return [];
}

/** The environments; each has world, methods, seeds and task(method, seed, letter). Runs are opened when asked for. */
export function openDataset(raw) {
  const letters = raw.actions.map((name) => name[0].toUpperCase());
  const readActions = (text) => Int8Array.from(text, (letter) => letters.indexOf(letter)); // -1 where undefined
  const environments = raw.environments.map((entry) => {
    const world = parseWorld(entry.map);
    const opened = new Map();
    return {
      ...entry,
      world,
      /** One method's record of one task, with its guides and the method itself. */
      task(method, seed, letter) {
        const name = `${method}/${seed}`;
        if (!opened.has(name)) opened.set(name, openRun(world, entry.runs[name], readActions));
        const run = opened.get(name);
        const index = entry.tasks.indexOf(letter);
        const kind = { id: method, ...raw.methods[method] };
        return { ...run.tasks[index], method: kind, guides: guidesOf(run, kind, index) };
      },
    };
  });
  return { environments, actions: raw.actions, window: raw.window };
}
