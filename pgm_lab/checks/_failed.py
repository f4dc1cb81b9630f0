"""What a check raises."""


class CheckFailed(AssertionError):
    """An answer is wrong or missing; notebooks show the message without a traceback."""

    def _render_traceback_(self) -> list[str]:
        return [f"✗ {self}"]
