"""Chapter 9: its photos, figures, checks, predictions and task."""
