"""The slips of an exercise, each in its row: all have to be named."""

import os
import re

from pgm_book.common.checks import CheckFailed, hidden

ALL = os.environ.get("PGM_LAB_LARGEST_SAMPLES")  # in test-all


def unnamed(check, slips):
    """Hints of the rows (answer, ..., hint) that the check fails to give: what it does.

    A hint is searched for as by `pytest.raises(CheckFailed, match=hint)`. In test-all
    the slip has to fail on hidden inputs as well, with whatever hint.
    """
    found = []
    for *answer, hint in slips:
        said = "it passes"
        try:
            check(*answer)
        except CheckFailed as failed:
            said = str(failed)
            if re.search(hint, said):
                if not ALL or _fails_hidden(check, answer):
                    continue
                said = "it passes on hidden inputs"
        except Exception as error:
            said = repr(error)
        found.append((hint, said))
    return found


def _fails_hidden(check, answer):
    with hidden(2013):
        try:
            check(*answer)
        except Exception:
            return True
    return False
