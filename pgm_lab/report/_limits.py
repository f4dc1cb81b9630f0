"""The limits of the report, each with its reason."""

from pgm_lab.bundle.reliability import critical_value
from pgm_lab.bundle.result import Bundle
from pgm_lab.report import _findings, _input, _misfit
from pgm_lab.report._layout import NUMBERS
from pgm_lab.report._words import UM


def limits(result: Bundle) -> list[str]:
    """Say of each limit what it decides, and why it is so large."""
    few, weak = NUMBERS[_findings.FEW_RAYS], NUMBERS[int(_findings.WEAK)]
    r = _findings.CORRELATED
    return [
        _of_residuals(result),
        f"sigma0 and the parameters of the camera are tested at"
        f" {100 * _misfit.ALPHA:.0f} %, the usual level: one right model of"
        f" {1 / _misfit.ALPHA:.0f} is called wrong.",
        f"Correlations are listed above {r}: there the sd of an unknown is more than"
        f" {1 / (1 - r**2) ** 0.5:.1f} times what it would be if the other were known.",
        f"An observation with a redundancy number below {_findings.HARDLY} is called"
        " hardly controlled, as nine tenths of its error stay hidden.",
        f"A photo is weak with fewer than {few} rays: so many points give twice the"
        f" coordinates that its {few} unknowns need, and three leave nothing to check."
        f" It is weak too if its projection centre is more than {weak} times as"
        " uncertain as the median one; this is a choice, no test.",
        f"If sigma0 is more than {_misfit.SPOILT:g} times the stated one and a residual"
        f" is more than {_misfit.GROSS:g} times its limit, a blunder is the likeliest"
        " cause, and no parameter is judged before it is gone; both numbers are a"
        " choice.",
        "Image coordinates are doubted if the farthest lies less than"
        f" {_input.NEAREST:g} mm or more than {_input.FARTHEST:g} mm from the middle,"
        f" as in no camera, or {_input.SCALE:g} times nearer or farther than the start"
        " values have it; standard deviations below"
        f" {UM * UM * _input.FINEST:g} nm, which nobody measures.",
    ]


def _of_residuals(result: Bundle) -> str:
    """Say where the limit of a standardised residual comes from."""
    limit = critical_value(result)
    if limit == float("inf"):
        return "Without redundancy no residual can be tested."
    cause = (
        "It is divided by the sigma0 stated before, so its limit is that of the normal"
        " distribution (Baarda)."
        if result.residual_test == "w"
        else "It is divided by the estimated sigma0, so its limit is that of Pope's tau"
        f" with the redundancy {result.redundancy}; the larger that is, the nearer the"
        " limit comes to 3.29, that of the normal distribution."
    )
    return (
        f"A standardised residual above {limit:.2f} makes a ray suspect: chance takes"
        " one of a thousand beyond it, so that a good network of a thousand coordinates"
        f" has about one false alarm. {cause}"
    )
