"""The whole argument on environment 2: learn, measure, judge and draw.

Six methods learn six tasks in a row, each with 30 seeds. The runs are measured, the article's claims on this
environment are judged by the measures, and the learning curves of the last task are drawn. That takes about ten seconds
and needs neither the workflow nor result files. Seeds and random numbers are those of the published tables, so the
numbers are the same; the published verdicts rest on thousands of further runs.

`python examples/whole_argument.py` runs it; `examples/whole_argument.ipynb` is the same as a notebook.
"""

# %% [markdown]
# ## The world
#
# `#` is a wall, `I` the start of every task, and the letters are the goals of the tasks, which are learned in
# alphabetical order. Environment 1 is loaded too, because one of the claims compares the sizes of the two.

# %%
from pathlib import Path

import ptl
from ptl import methods
from ptl.claims import CLAIMS
from ptl.claims.evidence import Evidence
from ptl.config import Growth, Measures, Parameters, Statistics
from ptl.learning.lives import learn_lives
from ptl.measures.measures import BY_NAME, measure, runs_of
from ptl.measures.statistics import Resampling, summarise
from ptl.report.figures import NO_CURVE, curves
from ptl.text import estimate

MAPS = Path(ptl.__file__).resolve().parents[1] / "config/environments"
worlds = {name: ptl.load_map(MAPS / f"{name}.txt") for name in ("env1", "env2")}
print(worlds["env2"].text)

# %% [markdown]
# ## Learn
#
# Without transfer every task starts from nothing; with full transfer it starts from the action values of the task
# before. Policy reuse (Fernandez and Veloso) draws on the policies of all earlier tasks. PTL is the article's method,
# partial transfer learning with a library of skills. It has two variants: a supervisor names the skill, or the goal is
# unknown. A life is one seed under one method, from task A to task F.

# %%
METHODS = ["no_transfer", "full_transfer", "policy_reuse", "ptl", "ptl_supervised", "ptl_unknown_goal"]
TASKS = "ABCDEF"
runs = []
for method in METHODS:
    lives = learn_lives(worlds["env2"], TASKS, method, Parameters(), 2019, range(30), "env2")
    runs += runs_of("env2", method, TASKS, lives)

# %% [markdown]
# ## Measure
#
# Every measure has one value for each run. The table shows means on task F, the last one, with 95% intervals. Steps
# and episodes: fewer are better. The transfer ratio is the share of all steps that a method saves.

# %%
settings, how = Measures(), Resampling(Statistics().confidence, Statistics().resamples)
measured = measure(runs, worlds, settings.window, settings.threshold_factor, Parameters().learning)

SHOWN = ["first_episode", "threshold_episode", "total_steps", "transfer_ratio"]
estimates = summarise(measured.per_seed.query("task == 'F'"), how)
estimates["shown"] = [estimate(*values) for values in estimates[["mean", "ci_low", "ci_high"]].to_numpy()]
table = estimates.pivot(index="method", columns="metric", values="shown").loc[METHODS, SHOWN]
print(table.rename(columns=lambda name: BY_NAME[name].heading).rename_axis(index=None, columns=None).to_string())

# %% [markdown]
# ## Judge
#
# A claim consists of parts, each of which compares an estimate with what the claim says. It is reproduced if all parts
# hold, and partly reproduced if some do.

# %%
evidence = Evidence(
    per_seed=measured.per_seed,
    subgoals=measured.subgoals,
    steps=measured.steps,
    worlds=worlds,
    how=how,
    window=settings.window,
    breakpoint=Growth().breakpoint,
)
judgements = [claim.judge(evidence) for claim in CLAIMS if claim.id.startswith("E2-")]
for judged in judgements:
    held = sum(part.outcome == "holds" for part in judged.parts)
    print(f"{judged.claim.id}: {judged.verdict}, {held} of {len(judged.parts)} parts hold\n  {judged.claim.statement}")

# %% [markdown]
# ## Draw
#
# The panel of figure 12 for this environment: steps to the goal in each episode of task F, mean over the runs with a
# 95% interval, on a logarithmic scale. It is written to `whole_argument.png`.

# %%
drawn = [name for name in METHODS if name not in NO_CURVE]
looks = {name: (methods.load(name).label, methods.load(name).colour) for name in drawn}
frame = curves.curves(measured.steps, {"env2": worlds["env2"]}, {"env2": "F"}, drawn, Statistics())
figure = curves.draw(frame, {"env2": "Environment 2"}, looks)
figure.savefig("whole_argument.png", dpi=100, metadata={"Software": None})
figure
