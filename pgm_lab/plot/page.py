"""The page that carries the board of a calibration."""

import io
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from pgm_lab import _validate
from pgm_lab.calibration.board import ABOVE, ASIDE, BELOW, PAPERS, Board, ink

MM = 1 / 25.4  # in inches
RULER = 100  # mm
HOW = """Board: {name}
Glue it on glass or a plate. Measure A to B, A to D, A to C, B to D with a ruler,
each from the {point} to that of the other;
write lengths and their sd into board.json. Then photograph it from many sides."""


def page(board: Board, paper: str = "A4") -> bytes:
    """Return a PDF page at true size: the board, its letters, a ruler, what to do.

    Vectors throughout, on A4 or A3 in landscape, for a board that fits (see `usual`);
    the same board gives the same bytes.
    """
    whole = np.array(PAPERS[_validate.choice(paper, "paper", tuple(PAPERS))])
    size, free = np.array(board.size), whole - (2 * ASIDE, ABOVE + BELOW)
    with rc_context({"font.family": "DejaVu Sans", "pdf.fonttype": 42}):
        fig = Figure(figsize=tuple(whole * MM))
        FigureCanvasPdf(fig)
        left, bottom = (free - size) / 2 + (ASIDE, BELOW)

        def black(x: float, y: float, rectangles: np.ndarray, *circles: Any) -> None:
            """Fill all at once, so that nothing shows between the cells of a marker."""
            box = Path.unit_rectangle()
            ring = np.array([(0, 1), (2, 1), (2, 3), (0, 3), (0, 1)])
            parts = [Path(corners[ring], box.codes) for corners in rectangles]
            parts += [Path.circle(one[:2], one[2]) for one in circles]
            whole = Path.make_compound_path(*parts)
            patch = PathPatch(whole, facecolor="black", linewidth=0, snap=False)
            patch.set_transform(
                Affine2D().translate(x, y).scale(MM) + fig.dpi_scale_trans
            )
            fig.add_artist(patch)

        def write(x: float, y: float, words: str, points: float, **how: Any) -> None:
            how["transform"] = fig.dpi_scale_trans
            fig.text(x * MM, y * MM, words, fontsize=points, **how)

        rectangles, circles = ink(board)
        black(left + board.margin, bottom + board.margin, rectangles, *circles)
        for letter, (right, up) in zip("ABCD", [(0, 1), (1, 1), (1, 0), (0, 0)]):
            x = left + (size[0] + 3 if right else -3)
            side = {"ha": "left" if right else "right", "va": "top" if up else "bottom"}
            write(x, bottom + (size[1] - 1 if up else 1), letter, 20, **side)

        # A ruler with a line each mm, longer ones at 5 and 10
        mm = np.arange(RULER + 1.0)
        high = np.select([mm % RULER == 0, mm % 10 == 0, mm % 5 == 0], [6, 4, 3], 2)
        lines = np.stack([mm - 0.05, 0 * mm, mm + 0.05, high], 1)
        black(ASIDE, 6, np.concatenate([lines, [(0, 0, RULER, 0.2)]]))
        write(ASIDE, 14, f"Print at 100 %, measure this: {RULER} mm", 9)

        name = f"{board.kind}, {board.columns} x {board.rows}, {board.square:g} mm"
        name += f", {board.dictionary}" if board.dictionary else ""
        point = "inner corner of a corner square"
        if board.kind == "apriltags":
            point = "outer corner of a corner tag"
        if "circles" in board.kind:
            point = "centre of a corner circle"
        for n, line in enumerate(HOW.format(name=name, point=point).splitlines()):
            write(ASIDE + RULER + 10, 17.5 - 3.8 * n, line, 8)
        file = io.BytesIO()
        about = {"CreationDate": None, "Producer": None, "Creator": "pgm_lab"}
        fig.savefig(file, format="pdf", metadata=about | {"Title": name})
    return file.getvalue()
