"""Checks of the exercises of the case of chapter 5, a validation of 2010."""

from collections.abc import Iterable

import numpy as np

from pgm_book.common.checks import CheckFailed, along_with, report

_MISPRINTED = {"b13", "b22", "b23", "b26"}


def misprints(names: Iterable[str]) -> None:
    """Check which coefficients of (M 2.24) the reader found misprinted.

    The names may stand in a list, tuple, set or array of any shape, or in one text
    with commas or spaces between them.
    """
    if isinstance(names, str):
        names = names.replace(",", " ").split()
    elif isinstance(names, np.ndarray):
        names = names.ravel()
    elif not isinstance(names, Iterable):
        names = ()
    try:
        names = [str(name) for name in names]
    except Exception:  # of a stranger's object
        names = []
    names = {name.strip().lower().replace("_", "") for name in names}
    if not names - {""}:
        raise CheckFailed(
            'misprinted is still empty: it must be a list of names such as "b11"'
        )
    known = {f"b{row}{column}" for row in (1, 2) for column in range(1, 7)}
    if names - known:
        raise CheckFailed(
            f"there is no coefficient {', '.join(sorted(names - known))}: write the"
            ' names like "b11"'
        )
    wrong, missed = len(names - _MISPRINTED), len(_MISPRINTED - names)
    report(
        "misprinted",
        [
            (
                "each of them fails",
                not wrong,
                f"{wrong} of your coefficients agree with the moved unknown",
            ),
            (
                "none is missed",
                along_with(not missed, wrong < len(_MISPRINTED)),  # not all are named
                f"{missed} more deviate: compare both rows, and mind that a relative"
                " deviation of 1e-8 is the finite difference, not a misprint",
            ),
        ],
    )
