"""Chapter 6: its figures, checks, predictions, studies and their results."""
