"""The report of a bundle adjustment: its sections, and the same as plain text."""

from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.snooping import Snooping
from pgm_lab.report import _findings, _tables, _words
from pgm_lab.report._input import doubt
from pgm_lab.report._layout import Section, as_text
from pgm_lab.report._limits import limits


def text(found: Bundle | Snooping, *, about: str = "", short: bool = False) -> str:
    """Report a bundle adjustment in plain text.

    Parameters
    ----------
    found : Bundle or Snooping
        What `adjust` or `snoop` returns.
    about : str
        A sentence for the head of the report: the object, the files, the date.
    short : bool
        Leave out the tables of photos and points.

    Returns
    -------
    str
        Lines of at most 88 characters, but for wide tables.

    Examples
    --------
    >>> from pgm_lab import bundle
    >>> from pgm_lab.camera import Camera
    >>> from pgm_lab.datasets import muliawan2013
    >>> data = muliawan2013()
    >>> measured = data.photo, data.point, data.xy, data.sigma
    >>> camera = Camera(*data.interior)
    >>> network = bundle.Network(camera, data.exteriors, data.object_points, *measured)
    >>> report = text(bundle.adjust(network), short=True)
    >>> report.splitlines()[3][:55]
    '9 photos of 50 points, taken with one camera: 450 rays.'
    """
    return as_text("Bundle adjustment", sections(found, about, short))


def sections(found: Bundle | Snooping, about: str, short: bool) -> list[Section]:
    """Collect the report, the summary first; what is empty is left out."""
    result = found.result if isinstance(found, Snooping) else found
    findings = _findings.findings(result)
    words = [] if findings else ["Nothing to warn of."]
    tables = []
    if isinstance(found, Snooping):
        words.append(_words.snooping(found))
        tables += [_tables.removed(found)] if found.removed else []
    if (blunders := _tables.blunders(result)) is not None:
        tables.append(blunders)
    head = (_words.summary(result, doubt(result.network)), *([about] if about else []))
    lens = _tables.lens(result)
    parts = [
        Section("Summary", head),
        Section("What to look at", words, findings, tables, ("residuals",)),
        Section("Camera", (), (), _tables.camera(result)),
    ]
    if lens:
        direction = _words.conventions(result)[1].partition(". ")[0] + "."
        parts.append(Section("Lens", (direction,), (), lens, ("lens",)))
    if not short:
        photos = _tables.photos(result)
        parts.append(Section("Photos", tables=photos, figures=("stations",)))
        one = [_tables.points(result)]
        parts.append(Section("Points", tables=one, figures=("precision",)))
    if known := _tables.known(result):
        parts.append(Section("Control and checks", tables=known))
    parts.append(Section("Datum", (_words.datum(result),)))
    if not short:
        parts.append(Section("Limits", limits(result)))
        parts.append(Section("Conventions", _words.conventions(result)))
    return parts
