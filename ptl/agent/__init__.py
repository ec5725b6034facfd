"""The agent: Q-learning on a map, skills and their library, and how a skill is chosen."""
