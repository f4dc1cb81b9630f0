"""The reader's program as the book solves it, in reading order."""
