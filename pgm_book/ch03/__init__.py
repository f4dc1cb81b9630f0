"""Chapter 3: its figures, checks, predictions, studies and their results."""
