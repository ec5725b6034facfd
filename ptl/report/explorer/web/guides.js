// The list of what can lead the agent, with its probability at the cursor; choosing one shows its arrows.

import { inkOn, parseHex, skillColour } from "./colour.js";
import { formatPercent } from "./format.js";
import { html, svg } from "./svg.js";

/** Name of a candidate for reading. */
export function guideName(task, candidate) {
  const kind = task.method.guides;
  if (candidate < 0 || candidate > task.guides.length) return "A policy of its own";
  if (candidate === 0) {
    return { skills: "No skill", policies: "New policy", none: "Learned policy" }[kind];
  }
  return kind === "skills" ? `Skill ${candidate}` : `Policy of ${task.guides[candidate - 1].from}`;
}

/** The same within a sentence. */
export function guideInSentence(task, candidate) {
  const name = guideName(task, candidate);
  return name[0].toLowerCase() + name.slice(1);
}

/** Label of a candidate's mark: skills have numbers, earlier policies the letter of their task. */
export function guideMark(task, candidate) {
  if (candidate === 0) return "";
  return task.method.guides === "skills" ? String(candidate) : task.guides[candidate - 1].from;
}

function describeGuide(world, task, candidate, mode) {
  if (candidate === 0) {
    return mode === "first" ? "no arrows in the first episode" : "arrows of the policy learned for this task";
  }
  const guide = task.guides[candidate - 1];
  if (guide.subgoal < 0) return `leads to goal ${guide.from}`;
  const [row, column] = world.cells[guide.subgoal];
  return `from task ${guide.from}, to row ${row}, column ${column}`;
}

function guideMarkPicture(task, candidate) {
  const fill = skillColour(candidate);
  const shape = svg("path", { d: "M11 1L21 11L11 21L1 11Z" });
  shape.style.fill = fill;
  const label = svg("text", { x: 11, y: 15 }, guideMark(task, candidate));
  label.style.fill = inkOn(parseHex(fill));
  return svg("svg", { viewBox: "0 0 22 22", class: "mark", "aria-hidden": "true" }, shape, label);
}

/** Fill a fieldset with one radio button a candidate. */
export function fillGuides(list, world, task, mode, name, chosen, choose) {
  const rows = Array.from({ length: 1 + task.guides.length }, (_, candidate) => {
    const input = html("input", { type: "radio", name, value: String(candidate) });
    input.checked = candidate === chosen;
    input.addEventListener("change", () => choose(candidate));
    const text = html(
      "span",
      { class: "guide-text" },
      html("b", {}, guideName(task, candidate)),
      html("small", {}, describeGuide(world, task, candidate, mode)),
    );
    const bar = html("span", { class: "bar" });
    bar.append(html("span", { class: "bar-fill" }));
    bar.firstChild.style.background = skillColour(candidate);
    const row = html("label", { class: "guide" }, input, guideMarkPicture(task, candidate), text);
    if (task.chances) row.append(bar, html("output", { class: "chance" }));
    return row;
  });
  list.replaceChildren(...rows);
}

/** Put the probabilities of an episode (counted from 1) into the list. */
export function showChances(list, task, episode) {
  if (!task.chances) return;
  [...list.children].forEach((row, candidate) => {
    const share = task.chances[candidate][episode - 1];
    row.querySelector(".bar-fill").style.width = `${100 * share}%`;
    const output = row.querySelector(".chance");
    output.value = formatPercent(share);
    output.dataset.share = share;
  });
}

/** What an episode drew, in words. */
export function describeDraws(task, episode) {
  const drawn = task.drawn[episode - 1];
  if (!drawn.length) return "";
  const names = drawn.map((candidate) => guideInSentence(task, candidate));
  const shown = names.length > 6 ? [...names.slice(0, 6), `and ${names.length - 6} more`] : names;
  return `Episode ${episode} drew ${shown.join(", then ")}.`;
}

/** Candidate with the highest probability in an episode, the first guide if the rule is not known. */
export function likeliestGuide(task, episode) {
  if (!task.chances) return Math.min(1, task.guides.length);
  const shares = task.chances.map((row) => row[episode - 1]);
  return shares.indexOf(Math.max(...shares));
}
