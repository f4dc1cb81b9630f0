"""How small the smallest writing of a figure is, for those who have to read it."""

from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure


class _Reader(RendererBase):
    """Draws nothing, and notes the size of all that is written."""

    def __init__(self, figure: Figure) -> None:
        super().__init__()
        self.size = figure.get_size_inches() * figure.dpi
        self.written: list[float] = []

    def get_canvas_width_height(self):
        return tuple(self.size)

    def points_to_pixels(self, points):
        return points  # lengths do not matter here

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):
        self.written.append(prop.get_size_in_points())

    def draw_nothing(self, *drawn, **how):
        pass

    draw_path = draw_markers = draw_path_collection = draw_nothing
    draw_quad_mesh = draw_gouraud_triangles = draw_image = draw_nothing


def smallest(figure: Figure) -> float | None:
    """Return the size in points of the smallest writing that is drawn, if any is.

    The figure was saved before, which laid it out; its layout is fixed from now on.
    Raised and lowered signs of a formula count with the size of the formula.
    """
    reader = _Reader(figure)
    figure.set_layout_engine("none")  # all is where it was when it was saved
    figure.draw(reader)
    return min(reader.written, default=None)
