"""Figures of a calibration: the page that carries the board."""

import io
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, Transform

from pgm_lab.calibration.board import ABOVE, ASIDE, BELOW, PAPERS, Board, ink

MM = 1 / 25.4  # in inches
RULER = 100  # mm
POINT = {
    "circles": "the centre of a corner circle",
    "asymmetric circles": "the centre of a corner circle",
    "apriltags": "the outer corner of a corner tag",
}
HOW = """Board: {name}
Glue it on glass or a plate. Measure A to B, A to D, A to C, B to D with a ruler,
each from {point} to that of the other;
write lengths and their sd into board.json. Then photograph it from many sides."""

# --- The page that carries the board ---


def board_page(board: Board, paper: str = "A4") -> bytes:
    """Return a PDF page at true size: the board, its letters, a ruler, what to do.

    Vectors throughout; the same board gives the same bytes.

    Parameters
    ----------
    board : calibration.board.Board
    paper : {"A4", "A3"}
        In landscape.

    Raises
    ------
    ValueError
        If the board does not fit.
    """
    if paper not in PAPERS:
        raise ValueError(f"paper must be one of {', '.join(PAPERS)}; got {paper!r:.20}")
    page, size = np.array(PAPERS[paper]), np.array(board.size)
    free = page - (2 * ASIDE, ABOVE + BELOW)
    if np.any(size > free + 1e-6):
        raise ValueError(
            f"a board of {size[0]:g} x {size[1]:g} mm does not fit on {paper}, which"
            f" leaves {free[0]:g} x {free[1]:g} mm"
        )
    with rc_context({"font.family": "DejaVu Sans", "pdf.fonttype": 42}):
        fig = Figure(figsize=tuple(page * MM))
        FigureCanvasPdf(fig)
        left, bottom = (free - size) / 2 + (ASIDE, BELOW)
        inches = fig.dpi_scale_trans
        on_page = Affine2D().translate(left + board.margin, bottom + board.margin)
        _black(fig, _outline(board), on_page.scale(MM) + inches)
        _black(fig, _ruler(), Affine2D().translate(ASIDE, 6).scale(MM) + inches)

        def write(x: float, y: float, words: str, points: float, **how: Any) -> None:
            fig.text(x * MM, y * MM, words, fontsize=points, transform=inches, **how)

        for letter, (across, up) in zip(
            board.letters, [(0, 1), (1, 1), (1, 0), (0, 0)]
        ):
            x = left + (size[0] + 3 if across else -3)
            y = bottom + (size[1] - 1 if up else 1)
            sides = {
                "ha": "left" if across else "right",
                "va": "top" if up else "bottom",
            }
            write(x, y, letter, 20, **sides)
        name = f"{board.kind}, {board.columns} x {board.rows}, {board.square:g} mm"
        name += f", {board.dictionary}" if board.dictionary else ""
        write(ASIDE, 14, f"Print at 100 %, measure this: {RULER} mm", 9)
        point = POINT.get(board.kind, "the inner corner of a corner square")
        for n, line in enumerate(HOW.format(name=name, point=point).splitlines()):
            write(ASIDE + RULER + 10, 17.5 - 3.8 * n, line, 8)
        file = io.BytesIO()
        about = {"CreationDate": None, "Producer": None, "Creator": "pgm_lab"}
        fig.savefig(file, format="pdf", metadata=about | {"Title": name})
    return file.getvalue()


def _outline(board: Board) -> Path:
    """The black parts as one path: filled at once, nothing shows between cells."""
    rectangles, circles = ink(board)
    box = Path.unit_rectangle()
    corners = np.array([(0, 1), (2, 1), (2, 3), (0, 3), (0, 1)])
    parts = [Path(r[corners], box.codes) for r in rectangles]
    return Path.make_compound_path(*parts, *(Path.circle(c[:2], c[2]) for c in circles))


def _ruler() -> Path:
    """A ruler of 100 mm with a line each mm, longer ones at 5 and 10."""
    bars = [(0.0, 0.0, float(RULER), 0.2)]
    for mm in range(RULER + 1):
        high = (
            6.0 if mm in (0, RULER) else 4 if mm % 10 == 0 else 3 if mm % 5 == 0 else 2
        )
        bars.append((mm - 0.05, 0.0, mm + 0.05, high))
    box = Path.unit_rectangle()
    corners = np.array([(0, 1), (2, 1), (2, 3), (0, 3), (0, 1)])
    return Path.make_compound_path(
        *(Path(np.array(bar)[corners], box.codes) for bar in bars)
    )


def _black(fig: Figure, path: Path, transform: Transform) -> None:
    """Fill a path with black."""
    patch = PathPatch(path, facecolor="black", linewidth=0, edgecolor="none")
    patch.set_transform(transform)
    patch.set_snap(False)
    fig.add_artist(patch)
