"""What several chapters share: checks, predictions, the ledger of verdicts."""
