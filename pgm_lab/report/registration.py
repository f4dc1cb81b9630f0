"""The report of a registration: how two images lie, how sure that is, what to check."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, matching, registration
from pgm_lab._rounding import plain
from pgm_lab.registration import Model, Raster, Registration
from pgm_lab.report import _registration_findings, _settings, _statuses
from pgm_lab.report import _registration_tables as _tables
from pgm_lab.report._layout import Section, as_html, as_text
from pgm_lab.report._registration_case import Case, headline, say, scatter

TITLE = "Image registration"
RATIO = np.sqrt(np.log(10))  # CE90 over RMSE_T of equal normal errors: 1.517
ROUNDING = 0.28  # px; the sd of a whole pixel is 1 / sqrt(12), or more


def html(
    found: Registration,
    reference: Raster | ArrayLike,
    sensed: Raster | ArrayLike,
    *,
    model: Model | None = None,
    pixel_size: float | None = None,
    settings: Mapping[str, object] | None = None,
    about: str = "",
) -> str:
    """Report a registration as an HTML page that needs no other file.

    Parameters
    ----------
    found : Registration
        What `registration.register` returned.
    reference, sensed : Raster or array_like (rows, columns)
        The images that were registered.
    model : Model, optional
        What `registration.fit` returned; without it, nothing is resampled.
    pixel_size : float, optional
        Of the reference image in metres, where the image itself does not say it.
    settings : mapping {name: value}, optional
        Arguments that `registration.register` was given, `refine` among them if it was;
        the report shows the defaults of the others.
    about : str
        A sentence for the head of the report: the place, the files, the date.

    Returns
    -------
    str
        The page with its figures, for light and dark screens and for paper.

    Raises
    ------
    ValueError
        If an argument is not what is described here.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> scene = landsat().grey
    >>> pair = scene[:200, :200], scene[2:202, 1:201]
    >>> points = registration.pick(pair[0], 9)
    >>> found = registration.register(*pair, points, refine="lsm")
    >>> html(found, *pair, settings={"refine": "lsm"}).splitlines()[0]
    '<!DOCTYPE html>'
    """
    from pgm_lab.report import _registration_figures  # matplotlib only when needed

    case = _case(found, reference, sensed, model, pixel_size, settings, about)
    return as_html(
        TITLE,
        _sections(case, about, short=False),
        lambda name: _registration_figures.pictures(name, case),
        {about} - {""},
    )


def text(
    found: Registration,
    reference: Raster | ArrayLike,
    sensed: Raster | ArrayLike,
    *,
    model: Model | None = None,
    pixel_size: float | None = None,
    settings: Mapping[str, object] | None = None,
    about: str = "",
    short: bool = False,
) -> str:
    """Report a registration in plain text.

    Parameters
    ----------
    found, reference, sensed, model, pixel_size, settings, about
        As for `html`.
    short : bool
        Leave out the points and how they were computed.

    Returns
    -------
    str
        Lines of at most 88 characters, but for wide tables.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> scene = landsat().grey
    >>> pair = scene[:200, :200], scene[2:202, 1:201]
    >>> points = registration.pick(pair[0], 9)
    >>> found = registration.register(*pair, points, refine="lsm")
    >>> words = text(found, *pair, settings={"refine": "lsm"}, short=True)
    >>> print(words.splitlines()[3][:61])
    The sensed image lies 1.00 px farther to the left and 2.00 px
    """
    case = _case(found, reference, sensed, model, pixel_size, settings, about)
    short = _validate.flag(short, "short")
    return as_text(TITLE, _sections(case, about, short))


def _case(
    found: Registration,
    reference: Raster | ArrayLike,
    sensed: Raster | ArrayLike,
    model: Model | None,
    pixel_size: float | None,
    settings: Mapping[str, object] | None,
    about: str,
) -> Case:
    _validate.instance(found, Registration, "found")
    if model is not None:
        _validate.instance(model, Model, "model")
        if len(model.used) != len(found.points):
            raise ValueError(
                f"model is of {len(model.used)} points, and found has"
                f" {len(found.points)}: fit it to this registration"
            )
    given = _settings.given(settings, about, _tables.SETTINGS)
    asked = _settings.values(registration.register, given, _tables.SETTINGS)
    sd = found.sd[found.accepted]
    if asked["refine"] is None and np.any(sd < ROUNDING):
        raise ValueError(
            "settings must say how the shifts were refined, for example"
            " {'refine': 'lsm'}: those of found are known better than whole pixels"
        )
    one = _raster(reference, "reference")
    size = one.pixel_size
    if size is None and pixel_size is not None:
        size = _validate.pair(pixel_size, "pixel_size", "m")
    return Case(found, one, _raster(sensed, "sensed"), model, asked, size)


def _raster(image: Raster | ArrayLike, name: str) -> Raster:
    if isinstance(image, Raster):
        return image
    values = matching.read(image, name)
    return Raster(np.ma.getdata(values), np.ma.getmaskarray(values))


def _sections(case: Case, about: str, short: bool) -> list[Section]:
    """Collect the report, the summary first; what is empty is left out."""
    found = case.found
    some = bool(np.any(found.accepted))
    findings = _registration_findings.findings(case)
    words = [] if findings else ["Nothing to warn of."]
    summary = [headline(case), *([scatter(case)] if some else []), *_remark(case)]
    summary += [about] if about else []
    parts = [
        Section("Summary", summary),
        Section("What to look at first", words, findings, (), ("overlay",)),
    ]
    if some:
        accuracy = [_tables.accuracy(case)]
        parts.append(Section("Accuracy", _accuracy(case), (), accuracy, ("scatter",)))
    if short:  # a table of sentences is too wide for a terminal
        reasons = _statuses.reasons(found, say)
        return [*parts, Section("Found and lost", (), reasons)]
    if case.model is not None:
        table = [_tables.model(case.model)]
        parts.append(Section("Model", _model(case.model), (), table))
    lost = [_statuses.statuses(found, say)]
    parts.append(Section("Found and lost", tables=lost, figures=("shifts",)))
    if some:
        parts.append(Section("r is not accuracy", (_r(),), figures=("similarity",)))
    parts += [
        Section("Points", tables=[_tables.points(case)]),
        Section("How it was computed", _steps(), (), [_asked(case)]),
        Section("Limits", _registration_findings.limits()),
    ]
    return parts


def _remark(case: Case) -> list[str]:
    """Say why there are no metres."""
    if case.pixel_size is not None:
        return []
    reason = case.reference.remark or "the size of a pixel on the ground is not known"
    return [f"Not in metres: {reason}."]


def _accuracy(case: Case) -> list[str]:
    """Say what the numbers mean, and which must not be compared."""
    a = case.found.accuracy
    right, down = ("east", "south") if case.north_up else ("right", "down")
    words = [
        "A shift is the place in the sensed image less the place in the reference"
        f" image: dx counts to the {right}, dy {down}. The mean shift is systematic,"
        " and resampling removes it; the spread about it stays. RMSE_x, RMSE_y"
        " and RMSE_T contain both."
    ]
    ratio = "" if a.rmse_t == 0 else f" Here it is {a.ce90 / a.rmse_t:.2f} times."
    words.append(
        "RMSE_T and CE90 are not like with like: the one is a root mean square, the"
        " other a length that nine tenths do not exceed. For normal errors, equal in"
        f" both coordinates and without a mean, CE90 is {RATIO:.3f} times RMSE_T; for a"
        f" common shift alone, both are the same.{ratio} Compare RMSE_T with a claim in"
        " RMSE_T, and CE90 with a claim in CE90."
    )
    return words


def _model(found: Model) -> list[str]:
    """Say what the parameters mean, and what sigma0 says."""
    column, row = found.centre
    formula = "dx = a0, dy = b0"
    if found.kind == "affine":
        formula = "dx = a0 + a1 x + a2 y, dy = b0 + b1 x + b2 y"
    words = f"The model is {formula}"
    if found.kind == "affine":
        words += (
            f", with x and y counted from column {column:.1f} and row {row:.1f} of the"
            " reference image"
        )
    words += (
        f". It follows from {np.sum(found.used)} points, weighted by what their chips"
        " predict; points that do not fit were left out."
    )
    verdict = (
        "so that the noise of the chips explains their scatter"
        if found.sigma0 < 1.5
        else "which is more than the noise of the chips explains"
    )
    return [
        words,
        f"sigma0 is {plain(found.sigma0)} (redundancy {found.redundancy}): the shifts"
        f" are {plain(found.sigma0)} times as far from the model as predicted,"
        f" {verdict}. The standard deviations of the parameters contain that factor,"
        " but nothing that all points are off together.",
    ]


def _r() -> str:
    """Say what r tells and what it does not."""
    return (
        "r, Pearson's correlation coefficient, says how much alike a chip and what was"
        " found are, but for brightness and contrast. The predicted standard deviation"
        " follows from noise and texture, and says how well that fixes the place. If r"
        " decided the accuracy, the points to the left would fall with r; if the"
        " prediction holds, nine tenths to the right lie below the line."
    )


def _asked(case: Case) -> _settings.Table:
    return _settings.table(case.asked, _tables.SETTINGS)


def _steps() -> tuple[str, ...]:
    """Say how a point was registered."""
    return (
        "A chip around each point of the reference image is compared with all places"
        " of the sensed image within the radius, by Pearson's correlation coefficient"
        " r; the best place is then refined between the pixels, if asked for. A point"
        " keeps the status of the first test that it did not pass: texture, data, a"
        " peak inside the search window, the least r, no second place almost as good."
        " The covariance is that of the refinement.",
    )
