"""Chapter 0: its figures, checks, predictions, studies and their results."""
