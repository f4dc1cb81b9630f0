"""The slips of an exercise, each in its row: all have to be named."""

import re

from pgm_book.common.checks import CheckFailed


def unnamed(check, slips):
    """Hints of the rows (answer, ..., hint) that the check fails to give: what it does.

    A hint is searched for as by `pytest.raises(CheckFailed, match=hint)`.
    """
    found = []
    for *answer, hint in slips:
        said = "it passes"
        try:
            check(*answer)
        except CheckFailed as failed:
            said = str(failed)
            if re.search(hint, said):
                continue
        except Exception as error:
            said = repr(error)
        found.append((hint, said))
    return found
