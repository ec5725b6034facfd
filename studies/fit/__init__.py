"""The search for a reading of the article that fits its claims: a frozen record, see README.md."""
