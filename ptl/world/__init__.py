"""Maps and moves: from the text of a map to states, transitions and shortest paths."""
