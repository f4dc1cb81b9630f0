"""Chapter 4: its figures, checks, predictions, studies and their results."""
