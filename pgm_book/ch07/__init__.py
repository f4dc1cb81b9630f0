"""Chapter 7: its figures, checks, predictions, studies and their results."""
