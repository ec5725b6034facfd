"""A first look: a map, a life of six tasks, what it learned, and how fast.

PTL learns the six tasks of environment 2, one after another, with the defaults of the published run. That takes less
than a second. `python examples/first_look.py` runs it; `examples/first_look.ipynb` is the same as a notebook.
"""

# %% [markdown]
# ## Learn
#
# `#` is a wall, `I` the start and the letters are the goals. After each task the library gets a skill, or not, and says
# why.

# %%
from pathlib import Path

from matplotlib.figure import Figure

import ptl

MAPS = Path(ptl.__file__).resolve().parents[1] / "config/environments"
world = ptl.load_map(MAPS / "env2.txt")
life = ptl.learn_life(world, "ABCDEF")
for record in life.records:
    print(f"task {record.task.name}: {record.steps[0]:,} steps in the first episode, {record.steps[-1]} in the last,")
    print(f"        subgoal: {record.update.reason}")

# %% [markdown]
# ## Map and skills
#
# Rings show the subgoals of the library's skills.

# %%
maps = Figure(figsize=(10, 4), layout="constrained")
ptl.plot_map(maps.add_subplot(), world, [skill.subgoal for skill in life.library])
maps.savefig("first_look_map.png")
maps

# %% [markdown]
# ## Values and policy
#
# The greatest action value of each state after the last task, on a log scale, and the greedy actions.

# %%
values = Figure(figsize=(10, 4), layout="constrained")
ptl.plot_values(values.add_subplot(), world, life.records[-1].q)
values.savefig("first_look_values.png")
values

# %% [markdown]
# ## Learning curves
#
# The last task after the five before it, and learned from nothing, also with more random actions. One life shows no
# more than how this looks; the published run has 30 for each method.

# %%
after = life.records[-1]
[alone] = ptl.learn_life(world, "F", "no_transfer").records
[wilder] = ptl.learn_life(world, "F", "no_transfer", ptl.Parameters(epsilon=0.3)).records

curves = Figure(figsize=(10, 4), layout="constrained")
axes = curves.add_subplot()
for record, label in ((alone, "from nothing"), (wilder, "from nothing, epsilon 0.3"), (after, "PTL after five tasks")):
    ptl.plot_curve(axes, record, label)
axes.legend()
curves.savefig("first_look_curves.png")
curves
