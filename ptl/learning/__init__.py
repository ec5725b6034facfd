"""Lives of the agent: tasks in order, random tasks, and the survey of all pairs of start and goal."""
