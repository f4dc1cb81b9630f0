"""Chapter NUMBER, LOWER: its checks, figures and predictions."""
