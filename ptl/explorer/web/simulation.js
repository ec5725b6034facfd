// A first episode as it is learned, drawn anew in the browser by the rules of ptl/_kernel.pyx and ptl/methods.

/** Seeded random numbers in [0, 1) (sfc32), so a shared address shows the same episode. */
export function randomNumbers(seed) {
  let [a, b, c, counter] = [0x9e3779b9, 0x243f6a88, seed >>> 0, 1];
  const next = () => {
    const sum = (a + b + counter) | 0;
    counter = (counter + 1) | 0;
    a = b ^ (b >>> 9);
    b = (c + (c << 3)) | 0;
    c = ((c << 21) | (c >>> 11)) + sum | 0;
    return (sum >>> 0) / 4294967296;
  };
  for (let i = 0; i < 15; i += 1) next();
  return next;
}

/** Index drawn with the given probabilities. */
export function drawIndex(probabilities, number) {
  let sum = 0;
  for (let i = 0; i < probabilities.length; i += 1) {
    sum += probabilities[i];
    if (number < sum) return i;
  }
  return probabilities.length - 1;
}

/**
 * One episode, advanced a few steps at a time.
 *
 * options: world, start, goal, kind ("explore", "skills", "reuse"), guides (of candidates 1, 2, ...; {policy, subgoal}),
 * chances (of all candidates), initial (action values or null), parameters (of the run), random.
 */
export class FirstEpisode {
  constructor(options) {
    Object.assign(this, options);
    const { learning, skills, policy_reuse: reuse } = this.parameters;
    this.learning = learning;
    this.q = this.initial ? Float64Array.from(this.initial) : new Float64Array(4 * this.world.size);
    this.state = this.start;
    this.steps = 0;
    this.visits = new Uint32Array(this.world.size);
    this.visits[this.start] = 1;
    this.drawn = [];
    this.guide = null; // followed at this moment
    this.budget = Infinity; // steps of exploration left before another draw
    this.epsilon = learning.epsilon;
    this.psi = 0;
    this.done = false;
    if (this.kind === "skills") {
      this.patience = skills.patience * this.world.size;
      this.#drawSkill();
    } else if (this.kind === "reuse") {
      const arm = this.#draw();
      this.epsilon = 0;
      if (arm > 0) {
        this.guide = this.guides[arm - 1];
        this.psi = reuse.psi;
      }
    }
  }

  /** Take up to `count` steps; returns whether the episode is over. */
  advance(count) {
    for (let i = 0; i < count && !this.done; i += 1) {
      if (this.kind === "reuse") this.#reuseStep();
      else if (this.guide) this.#followStep();
      else this.#exploreStep();
    }
    return this.done;
  }

  #draw() {
    const candidate = drawIndex(this.chances, this.random());
    this.drawn.push(candidate);
    return candidate;
  }

  #drawSkill() {
    const { skill_use: use, patience_growth: growth } = this.parameters.skills;
    const skill = this.#draw();
    this.guide = skill === 0 ? null : this.guides[skill - 1];
    this.budget = use === "reselect" ? Math.max(1, Math.round(this.patience)) : Infinity;
    this.patience *= growth;
    if (this.guide) this.#checkGuide();
  }

  #checkGuide() {
    if (this.state === this.guide.subgoal || this.guide.policy[this.state] < 0) this.guide = null;
  }

  #followStep() {
    this.#take(this.guide.policy[this.state]);
    this.#checkGuide();
  }

  #exploreStep() {
    this.#take(this.random() < this.epsilon ? this.#anyAction() : this.#greedyAction());
    this.budget -= 1;
    if (this.budget <= 0 && !this.done) this.#drawSkill();
  }

  #reuseStep() {
    const past = this.guide ? this.guide.policy[this.state] : -1;
    if (this.psi > 0 && past >= 0 && this.random() < this.psi) this.#take(past);
    else this.#take(this.random() < this.psi ? this.#anyAction() : this.#greedyAction());
    this.psi *= this.parameters.policy_reuse.psi_decay;
  }

  #anyAction() {
    return Math.floor(4 * this.random());
  }

  #greedyAction() {
    const first = 4 * this.state;
    const best = this.#best(this.state);
    const ties = [];
    for (let action = 0; action < 4; action += 1) if (this.q[first + action] === best) ties.push(action);
    return ties[Math.floor(ties.length * this.random())];
  }

  #best(state) {
    const q = this.q;
    return Math.max(q[4 * state], q[4 * state + 1], q[4 * state + 2], q[4 * state + 3]);
  }

  #take(action) {
    const { alpha, gamma, max_steps: limit } = this.learning;
    const place = 4 * this.state + action;
    const next = this.world.successors[place];
    const target = next === this.goal ? 1 : gamma * this.#best(next);
    this.q[place] += alpha * (target - this.q[place]);
    this.state = next;
    this.steps += 1;
    this.visits[next] += 1;
    this.done = next === this.goal || this.steps >= limit;
  }
}
