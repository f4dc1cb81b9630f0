"""The one error of this package: something a person can put right."""


class PublishError(Exception):
    """Publishing stopped; the message says what was wrong and what to do."""
