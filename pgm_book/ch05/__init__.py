"""Chapter 5: its figures, checks, predictions, studies and their results."""
