"""The seeded scripts that make the tables in data/results."""
