"""Chapter 2: its figures, checks, predictions, studies and their results."""
