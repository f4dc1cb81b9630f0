"""Formulas and numbers of the report as a person writes them, for HTML.

The text of the report is plain: r^3, mm^-2, sigma0, 1.2e-05. Here it gets Greek
letters, real minus signs, sub- and superscripts. Names of photos, points and files stay
as they are.
"""

import re
from collections.abc import Callable, Iterable

from markupsafe import Markup, escape

GREEK = {"sigma": "σ", "omega": "ω", "phi": "φ", "kappa": "κ", "tau": "τ", "rho": "ρ"}
RULES: tuple[tuple[str, Callable[[re.Match], str]], ...] = (
    (r"v'P", lambda found: "v<sup>T</sup>P"),
    (r"\bsqrt\(", lambda found: "√("),
    (r"\bsigma0(?!_)", lambda found: "σ<sub>0</sub>"),
    (r"_(omega|phi|kappa)\b", lambda found: f"<sub>{GREEK[found[1]]}</sub>"),
    (r"\b(sigma|omega|phi|kappa|tau|rho)\b", lambda found: GREEK[found[1]]),
    (
        r"(?<![\w.])([KP][123]|[ab][012]|[xyXYZ]0)(?!\w|\.\w)",
        lambda found: f"{found[1][0]}<sub>{found[1][1]}</sub>",
    ),
    (r"\bRMSE_([xyT])(?!\w|\.\w)", lambda found: f"RMSE<sub>{found[1]}</sub>"),
    (r"(?<=[\w)])\^(-?\d+)", lambda found: f"<sup>{_minus(found[1])}</sup>"),
    (
        r"(?<=\d)e([-+])0*(\d+)\b",
        lambda found: f" × 10<sup>{_minus(found[1].strip('+'))}{found[2]}</sup>",
    ),
    (r"(?<![^ =(|])-(?=[\d.]|[a-z ])(?!-)", lambda found: "−"),
)
_ANY = re.compile("|".join(f"(?P<rule{i}>{one})" for i, (one, _) in enumerate(RULES)))


def typesetter(names: Iterable[object]) -> Callable[[str], Markup]:
    """Return a function that typesets text, but for some names in it."""
    odd = {str(name) for name in names if _ANY.search(str(name))}
    kept = re.compile("|".join(map(re.escape, sorted(odd, key=len, reverse=True))))

    def typeset(text: str) -> Markup:
        if not odd:
            return _typeset(text)
        parts, end = [], 0
        for name in kept.finditer(text):
            parts += [_typeset(text[end : name.start()]), escape(name[0])]
            end = name.end()
        return Markup("").join([*parts, _typeset(text[end:])])

    return typeset


def _typeset(text: str) -> Markup:
    parts, end = [], 0
    for found in _ANY.finditer(text):
        number = int(str(found.lastgroup).removeprefix("rule"))
        pattern, write = RULES[number]
        whole = re.compile(pattern).match(text, found.start())
        assert whole
        parts += [escape(text[end : found.start()]), Markup(write(whole))]
        end = found.end()
    return Markup("").join([*parts, escape(text[end:])])


def _minus(number: str) -> str:
    return number.replace("-", "−")
