"""Chapter A1: its figures, checks, predictions, studies and their results."""
