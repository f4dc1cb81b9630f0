"""The report of a bundle adjustment as one HTML page, figures included."""

from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.snooping import Snooping
from pgm_lab.report._layout import as_html
from pgm_lab.report._text import sections


def html(found: Bundle | Snooping, *, about: str = "") -> str:
    """Report a bundle adjustment as an HTML page that needs no other file.

    Parameters
    ----------
    found : Bundle or Snooping
        What `adjust` or `snoop` returns.
    about : str
        A sentence for the head of the report: the object, the files, the date.

    Returns
    -------
    str
        The page with its figures, for light and dark screens and for paper.

    Examples
    --------
    >>> from pgm_lab import bundle
    >>> from pgm_lab.camera import Camera
    >>> from pgm_lab.datasets import muliawan2013
    >>> data = muliawan2013()
    >>> measured = data.photo, data.point, data.xy, data.sigma
    >>> camera = Camera(*data.interior)
    >>> network = bundle.Network(camera, data.exteriors, data.object_points, *measured)
    >>> html(bundle.adjust(network)).splitlines()[0]
    '<!DOCTYPE html>'
    """
    from pgm_lab.report import _figures  # matplotlib only when it is needed

    result = found.result if isinstance(found, Snooping) else found
    names = {*result.network.photo_names, *result.network.point_names}
    return as_html(
        "Bundle adjustment",
        sections(found, about, short=False),
        lambda name: _figures.pictures(name, result),
        names | {about} - {""},
    )
