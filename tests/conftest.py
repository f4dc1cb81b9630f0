"""Settings for all tests, and what the tests of figures share."""

import pytest
from hypothesis import settings

# The same examples in every run, on however slow a machine: no test fails by chance.
settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")


@pytest.fixture
def figures(monkeypatch):
    """Figures and texts that are shown, and closed in the end."""
    import matplotlib.pyplot as plt  # here, for most tests draw nothing

    from pgm_lab import plot

    shown = []
    for room in (plot, plot.basic):
        monkeypatch.setattr(
            room, "show", lambda fig, alt, **_: shown.append((fig, alt))
        )
    yield shown
    for fig, _ in shown:
        plt.close(fig)


@pytest.fixture
def closed():
    """Close the figures that a test gets."""
    import matplotlib.pyplot as plt

    yield
    plt.close("all")


@pytest.fixture
def alt_of(figures, capsys):
    """A function that draws, and returns the words of all that is shown."""

    def said(draw, *arguments, **named):
        before = len(figures)
        draw(*arguments, **named)
        for fig, _ in figures[before:]:
            fig.set_layout_engine("none")  # it takes as long as the drawing
            fig.draw_without_rendering()
        return " ".join(
            [alt for _, alt in figures[before:]] + [capsys.readouterr().out]
        )

    return said
