// The view as the fragment of the address, so that it can be shared; what cannot be shown falls to a sensible view.

const PLAY_MODES = ["first", "guided", "greedy"];
const MAP_LAYERS = ["value", "metric"];

function pick(wanted, options, otherwise) {
  return options.includes(wanted) ? wanted : otherwise;
}

function pickNumber(text, low, high, otherwise) {
  return /^\d+$/.test(text ?? "") ? Math.min(high, Math.max(low, Number(text))) : otherwise;
}

/** The view that a fragment asks for, made valid for the data set. */
export function readAddress(fragment, dataset) {
  const asked = Object.fromEntries(new URLSearchParams(fragment.replace(/^#/, "")));
  const names = dataset.environments.map((environment) => environment.name);
  const environment = dataset.environments[Math.max(0, names.indexOf(asked.environment))];
  const { methods, tasks } = environment;
  const method = pick(asked.method, methods, pick("ptl", methods, methods[methods.length - 1]));
  const others = methods.filter((name) => name !== method);
  const other = pick(asked.with, others, pick("no_transfer", others, others[0] ?? method));
  const seed = pick(Number(asked.seed ?? NaN), environment.seeds, environment.seeds[0]);
  // a task in the middle: the last one has the largest library behind it
  const task = pick(asked.task, tasks, tasks[Math.floor(tasks.length / 2)]);
  const record = environment.task(method, seed, task);
  const otherRecord = environment.task(other, seed, task);
  return {
    environment: environment.name,
    task,
    seed,
    method,
    with: other,
    compare: others.length > 0 && asked.compare !== "no",
    mode: pick(asked.mode, PLAY_MODES, PLAY_MODES[0]),
    layer: pick(asked.layer, MAP_LAYERS, MAP_LAYERS[0]),
    // Episodes are counted from 1 in the address and on the page.
    episode: pickNumber(asked.episode, 1, record.steps.length, 1),
    guide: pickNumber(asked.guide, 0, record.guides.length, 0),
    guide2: pickNumber(asked.guide2, 0, otherRecord.guides.length, 0),
    theme: pick(asked.theme, ["light", "dark"], ""),
  };
}

/** The fragment of a view. */
export function writeAddress(view) {
  const kept = Object.entries(view).filter(([key, value]) => value !== "" && !(key === "compare" && value));
  return "#" + new URLSearchParams(kept.map(([key, value]) => [key, value === false ? "no" : String(value)]));
}
