// The grid world of a map text, as ptl/world/gridworld.py reads it: states row by row, actions north, south, west, east.

export const MOVES = [[-1, 0], [1, 0], [0, -1], [0, 1]];

export function parseWorld(text) {
  const lines = text.trimEnd().split("\n");
  const rows = lines.length;
  const columns = lines[0].length;
  const stateAt = new Int32Array(rows * columns).fill(-1);
  const cells = [];
  const letters = {};
  lines.forEach((line, row) => [...line].forEach((letter, column) => {
    if (letter === "#") return;
    stateAt[row * columns + column] = cells.length;
    if (letter !== ".") letters[letter] = cells.length;
    cells.push([row, column]);
  }));
  const successors = new Int32Array(cells.length * 4);
  cells.forEach(([row, column], state) => MOVES.forEach(([down, right], action) => {
    const [r, c] = [row + down, column + right];
    const inside = r >= 0 && r < rows && c >= 0 && c < columns;
    const next = inside ? stateAt[r * columns + c] : -1;
    successors[4 * state + action] = next < 0 ? state : next;
  }));
  const { I: start, ...goals } = letters;
  return { rows, columns, cells, stateAt, successors, start, goals, size: cells.length };
}

/** Steps of the shortest path from every state to a state, -1 where there is none. */
export function distancesTo(world, target) {
  const distance = new Int32Array(world.size).fill(-1);
  distance[target] = 0;
  const queue = [target];
  for (const state of queue) {
    for (let action = 0; action < 4; action += 1) {
      const next = world.successors[4 * state + action]; // moves of a grid can be taken back
      if (distance[next] < 0) {
        distance[next] = distance[state] + 1;
        queue.push(next);
      }
    }
  }
  return distance;
}
