"""A figure that follows sliders, as an output of its cell."""

from collections.abc import Callable
from typing import Any

from IPython.display import DisplayHandle, display
from IPython.utils.capture import capture_output
from ipywidgets import ValueWidget


def interact(draw: Callable[..., object], **sliders: ValueWidget) -> None:
    """Show sliders and below them what a function draws, anew after each move.

    `ipywidgets.interact` gives the picture to a widget of the page. Where a program
    plays the page, as ``nbconvert --execute`` does, a message between the two is lost
    now and then, and the run stands still for minutes. Here the picture is an output
    of the cell, which a new one replaces; nothing waits for an answer, and a notebook
    keeps the first picture.

    Parameters
    ----------
    draw : callable
        Called with the values of the sliders; it shows one figure (`show`), or prints.
    **sliders : ipywidgets.ValueWidget
        One for each argument of `draw`, by its name.

    Raises
    ------
    ValueError
        If `draw` cannot be called, or a slider is not a widget with a value.

    Examples
    --------
    >>> from ipywidgets import IntSlider
    >>> interact(lambda size: print(size, "px"), size=IntSlider(21, 3, 61))
    IntSlider(value=21, max=61, min=3)
    ...21 px...
    """
    if not callable(draw):
        raise ValueError(f"draw must be a function of the sliders, not {draw!r}")
    for name, slider in sliders.items():
        if not isinstance(slider, ValueWidget):
            raise ValueError(f"{name} must be a widget with a value, not {slider!r}")
    place = DisplayHandle()
    display(*sliders.values())
    data, metadata = drawn(draw, sliders)
    place.display(data, metadata=metadata, raw=True)

    def redraw(_: object) -> None:
        data, metadata = drawn(draw, sliders)
        place.update(data, metadata=metadata, raw=True)

    for slider in sliders.values():
        slider.observe(redraw, "value")


def drawn(
    draw: Callable[..., object], sliders: dict[str, ValueWidget]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What `draw` shows or prints now, with its metadata, without showing it yet."""
    with capture_output(stderr=False) as seen:
        draw(**{name: slider.value for name, slider in sliders.items()})
    if seen.outputs:
        return seen.outputs[-1].data, seen.outputs[-1].metadata
    return {"text/plain": seen.stdout.rstrip()}, {}
