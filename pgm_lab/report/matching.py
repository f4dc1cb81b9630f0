"""The report of a matching: what was found, how well, and what to look at first."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from pgm_lab import _validate
from pgm_lab._rounding import plain
from pgm_lab.matching import Match
from pgm_lab.report import _match_findings, _match_tables, _settings, _statuses
from pgm_lab.report._layout import Section, Table, as_html, as_text

TITLE = "Image matching"


def html(
    found: Match,
    left: Any,
    right: Any,
    *,
    settings: Mapping[str, object] | None = None,
    about: str = "",
) -> str:
    """Report a matching as an HTML page that needs no other file.

    Parameters
    ----------
    found : matching.Match
        What `matching.match` returned.
    left, right : as for `matching.read`
        The photos that were matched; colours are drawn in grey.
    settings : mapping {name: value}, optional
        Arguments that `matching.match` was given; the report shows the defaults of the
        others.
    about : str
        A sentence for the head of the report: the object, the files, the date.

    Returns
    -------
    str
        The page with its figures, for light and dark screens and for paper.

    Raises
    ------
    ValueError
        If a photo has another size than the one that was matched.

    Examples
    --------
    >>> from pgm_lab import matching, simulate
    >>> shift = (3.25, 1, 0, -1.5, 0, 1)
    >>> grey = simulate.texture_pair(simulate.texture(seed=1), (90, 120), shift)
    >>> found = matching.match(*grey, number=5)
    >>> html(found, *grey).splitlines()[0]
    '<!DOCTYPE html>'
    """
    from pgm_lab.report import _match_figures  # matplotlib only when it is needed

    given = _given(found, settings, about)
    threshold = _match_tables.values(given).get("threshold")
    return as_html(
        TITLE,
        _sections(found, given, about, short=False),
        lambda name: _match_figures.pictures(name, found, left, right, threshold),
        {about} - {""},
    )


def text(
    found: Match,
    *,
    settings: Mapping[str, object] | None = None,
    about: str = "",
    short: bool = False,
) -> str:
    """Report a matching in plain text.

    Parameters
    ----------
    found : matching.Match
        What `matching.match` returned.
    settings : mapping {name: value}, optional
        Arguments that `matching.match` was given.
    about : str
        A sentence for the head of the report.
    short : bool
        Leave out the points and how they were computed.

    Returns
    -------
    str
        Lines of at most 88 characters, but for wide tables.

    Examples
    --------
    >>> from pgm_lab import matching, simulate
    >>> shift = (3.25, 1, 0, -1.5, 0, 1)
    >>> grey = simulate.texture_pair(simulate.texture(seed=1), (90, 120), shift)
    >>> report = text(matching.match(*grey, number=5), short=True)
    >>> report.splitlines()[3][:25]
    '5 of 5 points were found;'
    """
    given = _given(found, settings, about)
    short = _validate.flag(short, "short")
    return as_text(TITLE, _sections(found, given, about, short))


def _given(
    found: Match, settings: Mapping[str, object] | None, about: str
) -> Mapping[str, object]:
    _validate.instance(found, Match, "found")
    return _settings.given(settings, about, _match_tables.SETTINGS)


def _sections(
    found: Match, given: Mapping[str, object], about: str, short: bool
) -> list[Section]:
    """Collect the report, the summary first; what is empty is left out."""
    findings = _match_findings.findings(found)
    words = [] if findings else ["Nothing to warn of."]
    parts = [
        Section("Summary", (_summary(found), *([about] if about else []))),
        Section("What to look at first", words, findings, (), ("photos",)),
    ]
    if short:  # a table of sentences is too wide for a terminal
        return [*parts, Section("Found and lost", (), _statuses.reasons(found))]
    parts.append(Section("Found and lost", tables=[_statuses.statuses(found)]))
    if np.any(found.accepted):
        parts.append(Section("Precision", (_precision(),), figures=("histograms",)))
        moved = (_parallaxes(found),)
        parts.append(Section("Parallaxes", moved, figures=("parallaxes",)))
    parts += [
        Section("Points", tables=[_match_tables.points(found)]),
        Section("How it was computed", _steps(), (), [_asked(given)]),
        Section("Limits", _match_findings.limits()),
    ]
    return parts


def _asked(given: Mapping[str, object]) -> Table:
    return _settings.table(_match_tables.values(given), _match_tables.SETTINGS)


def _summary(found: Match) -> str:
    """Say in short how many points were found, and how well."""
    n, good = len(found.chosen), found.accepted
    if not np.any(good):
        return f"None of {n} points was found."
    sd, r = float(np.median(found.sd[good])), float(np.median(found.r[good]))
    return (
        f"{np.sum(good)} of {n} points were found; a typical one to {plain(sd)} px, as"
        f" its windows predict. Half of them have a correlation above {r:.3f}."
    )


def _precision() -> str:
    """Say what r and the standard deviation mean."""
    return (
        "r is the correlation coefficient of the two windows after matching: 1 if they"
        " differ in brightness and contrast only. The standard deviation (sd) is that"
        " of a coordinate, the root of the mean variance of column and row. It follows"
        " from noise and texture of the windows; an error that all pixels of a window"
        " share, as on an edge in depth or with a wrong match, is not in it."
    )


def _parallaxes(found: Match) -> str:
    """Say how the right photo lies to the left one."""
    dx, dy = np.median(_match_findings.parallaxes(found), axis=0)
    angle, scale = _match_findings.turn_and_scale(_match_findings.shape(found))
    return (
        f"From left to right photo a usual point moves by {plain(dx, 3)} columns and"
        f" {plain(dy, 3)} rows, and its window is turned by {angle:.1f} degrees"
        f" (clockwise if positive) and {plain(scale, 3)} times as large. These are"
        " medians. The arrows show what is left of the parallaxes when a common shift,"
        " turn, scale and shear are taken off: relief, and matches that do not fit"
        " their neighbours."
    )


def _steps() -> tuple[str, ...]:
    """Say how a point was matched."""
    return (
        "For each point a start value in the right photo and a start shape of its"
        " window are estimated; normalized cross correlation seeks the most similar"
        " place around it, and least squares matching refines that place and the shape."
        " The covariance is that of least squares matching. A point keeps the status of"
        " the first step that it did not pass.",
    )
