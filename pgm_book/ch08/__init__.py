"""Chapter 8: its figures, checks, predictions, studies and their results."""
