"""StereoMap in a notebook: click in the left photo, see the match, keep it, save.

The figure is a canvas of ipympl, made for this program alone: other figures of the
notebook stay what they are.
"""

import html
import os
from collections.abc import Callable
from types import ModuleType

import matplotlib
import numpy as np
from matplotlib.backend_bases import LocationEvent, MouseEvent
from matplotlib.figure import Figure

from pgm_lab import _validate
from pgm_lab.io.files import printable
from pgm_lab.stereo_map import drawing, measuring, saving, session
from pgm_lab.stereo_map.session import Measurement, Session

WIDTH, DETAILS = 8.1, 2.2  # inches, at 100 pixels each: beside JupyterLab's files
SMALL = 10  # points: writing on a screen
ZOOM = 1.5  # a step of the wheel
FINGER = 12  # pixels of the screen by which a click in the right photo may be off
HINT = (
    "Click in the left photo. The wheel zooms; the cross of arrows above moves the"
    " photos, until you click it again."
)
COLUMNS = ("point", "left (px)", "right (px)", "X", "Y", "Z", "sd", "y parallax (px)")


class Program:
    """The program, running: what it shows, and the session as it is now.

    Attributes
    ----------
    session : Session
        Changed by the buttons; set another one with `take`.
    point : Measurement or None
        The last one that was measured, kept or not.
    box : ipywidgets.Widget
        All of it, for `display`.
    """

    def __init__(self, first: Session, file: str | os.PathLike = "my_points.csv"):
        import ipywidgets as widgets

        _validate.instance(first, Session, "first")
        self.session: Session = first
        self.point: Measurement | None = None
        self._saved: set[str] = set()
        self._figure()
        self.message = widgets.HTML(HINT)
        self.message.add_class("stereo-map-message")
        self.table = widgets.HTML("")
        self.table.add_class("stereo-map-points")
        self.file = widgets.Text(str(file), layout={"width": "220px"})
        actions: dict[str, Callable[[], str]] = {
            "Keep": self._keep,
            "Undo": self._undo,
            "Orient": self._orient,
            "Save": self._save,
        }
        self.buttons = {name: widgets.Button(description=name) for name in actions}
        for name, button in self.buttons.items():
            button.on_click(lambda _, action=actions[name]: self._do(action))
        row = widgets.HBox([*self.buttons.values(), self.file])
        self.box = widgets.VBox([self.canvas, self.message, row, self.table])
        self._refresh()

    def take(self, other: Session) -> None:
        """Go on with another session, as one that was oriented by control points."""
        self.session = _validate.instance(other, Session, "other")
        self.point = None
        self._refresh()

    def _figure(self) -> None:
        rows, columns = self.session.left.grey.shape
        high = float(np.clip(WIDTH / 2 * rows / columns, 2.2, 4.5)) + 0.4
        figure = Figure(figsize=(WIDTH, high + DETAILS), dpi=100)
        figure.set_layout_engine("none")
        ipympl = _ipympl()
        self.canvas = ipympl.Canvas(figure)
        self.manager = ipympl.FigureManager(self.canvas, 1)
        self.canvas.header_visible = False
        self.canvas.capture_scroll = True
        self.canvas.resizable = False
        self.canvas.toolbar_visible = "visible"
        self.canvas.toolbar_position = "top"
        # Fixed places: a layout that is computed anew would take as long as the match
        share = DETAILS / (high + DETAILS)
        sides = {"left": 0.06, "right": 0.99}
        grids = (
            figure.add_gridspec(1, 2, bottom=share + 0.05, top=0.94, **sides),
            figure.add_gridspec(1, 4, bottom=0.06, top=share - 0.1, **sides),
        )
        titles = "left photo", "right photo"
        self.views = [
            drawing.View(figure.add_subplot(grids[0][k]), levels, titles[k], SMALL)
            for k, levels in enumerate(self.session.levels)
        ]
        self.details = [figure.add_subplot(grids[1][k]) for k in range(4)]
        for ax in self.details:
            ax.set_axis_off()
        self.canvas.mpl_connect("button_press_event", self._click)
        self.canvas.mpl_connect("scroll_event", self._scroll)

    def _click(self, event: LocationEvent) -> None:
        """Measure at a click in the left photo; one in the right says where to look."""
        assert isinstance(event, MouseEvent)
        if event.button != 1 or self.manager.toolbar.mode:
            return
        place = np.array([event.xdata, event.ydata], dtype=float)
        if event.inaxes is self.views[0].ax:
            self._do(lambda: self._measure(place))
        elif event.inaxes is self.views[1].ax and self.point is not None:
            left = self.point.left
            self._do(lambda: self._measure(left, place))

    def _measure(self, left: np.ndarray, near: np.ndarray | None = None) -> str:
        reach = max(25.0, FINGER * self.views[1].step)
        self.point = measuring.measure(self.session, left, near, reach=reach)
        self._follow()
        lines = map(html.escape, drawing.lines(self.session, self.point))
        return f'<div style="line-height: 1.5">{"<br>".join(lines)}</div>'

    def _follow(self) -> None:
        """Move the right view to the match, as large as the left view shows it."""
        left, right = self.views
        span = abs(np.subtract(*left.ax.get_xlim()))
        point = self.point
        if point is None or span > 0.9 * left.levels[0].shape[1]:
            return
        centre = point.right if point.accepted else point.start
        if np.isfinite(centre).all():
            right.show(centre, span)

    def _scroll(self, event: LocationEvent) -> None:
        """Zoom about the pixel under the mouse."""
        assert isinstance(event, MouseEvent)
        for view in self.views:
            if event.inaxes is view.ax:
                here = np.array([event.xdata, event.ydata])
                x0, x1 = view.ax.get_xlim()
                y0, y1 = view.ax.get_ylim()
                middle = np.array([x0 + x1, y0 + y1]) / 2
                factor = ZOOM**-event.step
                view.show(here + factor * (middle - here), factor * (x1 - x0))
                self.canvas.draw_idle()

    def _keep(self) -> str:
        if self.point is None:
            raise ValueError("there is no point yet: click in the left photo")
        self.session = session.add(self.session, self.point)
        self.point = None
        return f"Kept as point {self.session.points[-1].name}."

    def _undo(self) -> str:
        before = len(self.session.points)
        self.session = session.undo(self.session)
        self.point = None
        point = len(self.session.points) < before
        return (
            "The last point was removed." if point else "The orientation was removed."
        )

    def _orient(self) -> str:
        self.session = measuring.orient(self.session)
        self.point = None
        found = self.session.relative
        assert found is not None
        sigma = found.sigma0 / self.session.left.pixel_size
        return (
            f"Oriented by {len(self.session.points)} points ({found.status});"
            f" sigma0 = {sigma:.2f} px. Coordinates are in model units now."
        )

    def _save(self) -> str:
        path = self.file.value.strip()
        try:
            saving.save(self.session, path, overwrite=path in self._saved)
        except FileExistsError as error:
            raise FileExistsError(
                f"{error}: write another name beside the button"
            ) from None
        self._saved.add(path)
        number = len(self.session.points)
        points = "1 point is" if number == 1 else f"{number} points are"
        return f"{points} saved in {html.escape(printable(path))}."

    def _do(self, action: Callable[[], str]) -> None:
        """Do it and show what it says, or what went wrong."""
        try:
            self.message.value = action()
        except (ValueError, OSError) as error:
            self.message.value = f"✗ {html.escape(str(error))}"
        self._refresh()

    def _refresh(self) -> None:
        drawing.mark(self.views, self.session, self.point)
        if self.point is not None:
            drawing.details(self.details, self.point, SMALL)
        self.table.value = _table(self.session)
        self.canvas.draw_idle()


def _ipympl() -> ModuleType:
    """Canvases that answer to clicks; all other figures keep their own."""
    # Importing ipympl makes its canvas that of every later figure of matplotlib
    backend = matplotlib.get_backend()
    from ipympl import backend_nbagg

    matplotlib.use(backend)
    return backend_nbagg


def start(first: Session, file: str | os.PathLike = "my_points.csv") -> Program:
    """Show the program below the cell.

    Parameters
    ----------
    first : Session
        From `stereo_map.open_pair`, perhaps with points already.
    file : str or path
        Name that "Save" writes to, until the reader gives another one.

    Returns
    -------
    Program
        Its `session` is what was measured, at any time.
    """
    from IPython.display import display

    program = Program(first, file)
    display(program.box)
    return program


def _table(session: Session) -> str:
    """The points on the list as a table in HTML."""
    if not session.points:
        return "No points kept yet."
    rows = [_row(COLUMNS, "th")]
    for point in session.points:
        known = np.isfinite(point.xyz).all()
        sd = np.full(3, np.nan) if not known else point.sd
        numbers = [
            drawing.pixels(point.left),
            drawing.pixels(point.right),
            *(f"{value:.3f}" if known else "" for value in point.xyz),
            " ".join(f"{value:.3f}" for value in sd) if known else "",
            f"{point.y_parallax:.2f}" if known else "",
        ]
        rows.append(_row((str(point.name), *numbers), "td"))
    return f"<table>{''.join(rows)}</table>"


def _row(cells: tuple, tag: str) -> str:
    style = "padding: 0 0.7em; text-align: right"
    content = "".join(f'<{tag} style="{style}">{cell}</{tag}>' for cell in cells)
    return f"<tr>{content}</tr>"
