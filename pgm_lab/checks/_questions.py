"""Quick questions: the feedback to each choice stands in ``data/questions``."""

from collections.abc import Iterable

from pgm_lab import _validate, datasets
from pgm_lab.checks._failed import CheckFailed


def question(number: str, choice: str) -> None:
    """Answer a quick question; the feedback says why a choice is right or wrong.

    Parameters
    ----------
    number : str
        Number of the question, for example "1.2".
    choice : str
        Letter of the choice.

    Raises
    ------
    CheckFailed
        If the choice is wrong or missing.
    ValueError
        If there is no such question.
    """
    _validate.text(number, "number")
    rows = datasets.rows("questions")
    choices = {row["choice"]: row for row in rows if row["question"] == number}
    if not choices:
        raise ValueError(f"number: there is no question {number} in data/questions")
    letter = choice.strip().lower() if isinstance(choice, str) else ""
    if letter not in choices:
        raise CheckFailed(f"question {number}: choose one of {', '.join(choices)}.")
    row = choices[letter]
    if row["right"] != "yes":
        raise CheckFailed(f"question {number}: {row['feedback']}")
    print(f"✓ question {number}: {row['feedback']}")


def questions(chapter: str, choices: Iterable[str]) -> None:
    """Answer the quick questions of a chapter; each choice gets its feedback.

    Parameters
    ----------
    chapter : str
        Number of the chapter, for example "1".
    choices : iterable of str
        A letter for each question, in their order.

    Raises
    ------
    CheckFailed
        If a choice is wrong or missing, after all questions were looked at.
    """
    _validate.text(chapter, "chapter")
    known = {row["question"] for row in datasets.rows("questions")}
    wanted = sum(number.startswith(f"{chapter}.") for number in known)
    try:
        choices = list(choices)
    except Exception:  # whatever a stranger's object raises
        choices = []
    if len(choices) != wanted:
        raise CheckFailed(f"give {wanted} letters, one for each question.")
    failed = []
    for number, choice in enumerate(choices, start=1):
        try:
            question(f"{chapter}.{number}", choice)
        except CheckFailed as wrong:
            failed.append(str(wrong))
    if failed:
        raise CheckFailed("\n✗ ".join(failed))
