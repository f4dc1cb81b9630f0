r"""Questions in the formats of exam systems: GIFT, Moodle XML and QTI 2.1.

Formulas stay TeX between ``\(`` and ``\)`` in all three: Moodle sets them by its
MathJax filter, and so do the systems that import QTI. MathML would be read by all
browsers too, but only a program more could make it from TeX.

References
----------
- GIFT: https://docs.moodle.org/en/GIFT_format
- Moodle XML: https://docs.moodle.org/en/Moodle_XML_format
- QTI 2.1: https://www.imsglobal.org/question/qtiv2p1/imsqti_infov2p1.html
- Content packages: https://www.imsglobal.org/content/packaging/cpv1p1p4/imscp_infov1p1p4.html
"""

import base64
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from html import escape
from io import BytesIO
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from pgm_book.course.numbers import Chance, Variant
from pgm_book.course.questions import ChoiceQuestion, html

Question = ChoiceQuestion | Variant
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def key(question: Question) -> str:
    """Return an identifier that stays, and is one in every format."""
    return f"pgm-{question.number}"


def title(question: Question) -> str:
    """Return number and title, by which a lecturer finds a question."""
    return f"{question.number} {question.title}"


def body(question: Question, source: str) -> str:
    """Write the text in XHTML, with its figure; `source` is where its file lies."""
    text = html(question.text)
    picture = getattr(question, "picture", None)
    if picture:
        alt, source = escape(picture.alt), source.format(picture.name)
        text += f'\n<p><img src="{source}" alt="{alt}"/></p>'
    return text


def fixed(value: float) -> str:
    """Write a number without an exponent, which not every reader knows.

    Examples
    --------
    >>> fixed(1e-7), fixed(-1250.0), fixed(0.001)
    ('0', '-1250', '0.001')
    """
    return f"{round(value, 6) + 0.0:.6f}".rstrip("0").rstrip(".")


def slip(words: str) -> str:
    """Return what is said to whoever made a usual slip."""
    return f"<p>Think again: {escape(words)}.</p>"


def checked(text: str) -> str:
    """Return a text that every format can hold; a control character is an error."""
    found = CONTROL.search(text)
    if found:
        raise ValueError(f"a control character, {found[0]!r}, in {text[:60]!r}")
    return text


# --- GIFT ---


def gift(categories: Mapping[str, Iterable[Question]]) -> str:
    """Write questions in GIFT; a figure is a data URI.

    The format has no flag for shuffling: choices stand in an order of chance.
    """
    blocks = []
    for category, questions in categories.items():
        blocks.append(f"$CATEGORY: pgm_lab/{category}")
        blocks += map(_gift, questions)
    return checked("\n\n".join(blocks) + "\n")


def _gift(question: Question) -> str:
    uri = "{}"
    if isinstance(question, ChoiceQuestion) and question.picture:
        uri = "data:image/png;base64," + base64.b64encode(question.picture.png).decode()
    head = f"// [id:{key(question)}]\n::{_plain(title(question))}::[html]"
    text = _plain(body(question, uri))
    if isinstance(question, Variant):
        near = fixed(question.tolerance)
        lines = [f"={fixed(question.answer)}:{near}"]
        lines += [
            f"=%0%{fixed(value)}:{near}#{_plain(slip(words))}"
            for words, value in question.slips.items()
        ]
        lines.append(f"####{_plain(html(question.solution))}")
        return "\n\t".join([f"{head}{text} {{#", *lines]) + "\n}"
    lines = [
        f"{'=' if one.right else '~'}{_choice(one.text)}#{_choice(one.feedback)}"
        for one in Chance(question.number).order(question.choices)
    ]
    return "\n\t".join([f"{head}{text} {{", *lines]) + "\n}"


def _choice(text: str) -> str:
    """Write plain text; where it began with % it would be a weight."""
    return _plain(re.sub("^%", "&percnt;", escape(text, quote=False)))


def _plain(text: str) -> str:
    """Escape what GIFT reads as a sign of its own; an empty line would end all."""
    text = re.sub(r"\s*\n\s*", " ", text)
    return re.sub(r"([\\~=#{}:])", r"\\\1", text)


# --- Moodle XML ---


def moodle(categories: Mapping[str, Iterable[Question]]) -> str:
    """Write questions in Moodle's own XML, figures within.

    The variants of a question with numbers are questions of one category, from which a
    quiz takes one by chance. Moodle's calculated questions would compute the answer
    again, with formulas that have no loops and no matrices.
    """
    quiz = ET.Element("quiz")
    for category, questions in categories.items():
        made = _add(quiz, "question", type="category")
        _add(_add(made, "category"), "text", f"$course$/top/pgm_lab/{category}")
        for question in questions:
            _moodle(quiz, question)
    ET.indent(quiz)
    return _written(quiz)


def _moodle(quiz: ET.Element, question: Question) -> None:
    choice = isinstance(question, ChoiceQuestion)
    made = _add(quiz, "question", type="multichoice" if choice else "numerical")
    _add(_add(made, "name"), "text", title(question))
    asked = _text(made, "questiontext", body(question, "@@PLUGINFILE@@/{}"))
    solution = html(question.solution) if isinstance(question, Variant) else ""
    _text(made, "generalfeedback", solution)
    some = {"defaultgrade": 1, "penalty": 0.3333333, "hidden": 0}
    _all(made, some | {"idnumber": key(question)})
    if isinstance(question, ChoiceQuestion):
        if question.picture:
            png = base64.b64encode(question.picture.png).decode()
            file = {"name": question.picture.name, "path": "/", "encoding": "base64"}
            _add(asked, "file", png, **file)
        _moodle_choices(made, question)
    else:
        _moodle_numbers(made, question)


def _moodle_choices(made: ET.Element, question: ChoiceQuestion) -> None:
    _all(made, {"single": "true", "shuffleanswers": "true", "answernumbering": "abc"})
    for one in question.choices:
        answer = _text(made, "answer", escape(one.text), fraction=100 * one.right)
        _text(answer, "feedback", escape(one.feedback))


def _moodle_numbers(made: ET.Element, question: Variant) -> None:
    answers = [(question.answer, 100, "")]
    answers += [(value, 0, slip(words)) for words, value in question.slips.items()]
    for value, fraction, said in answers:
        answer = _add(made, "answer", fraction=fraction, format="moodle_auto_format")
        _add(answer, "text", fixed(value))
        _text(answer, "feedback", said)
        _add(answer, "tolerance", fixed(question.tolerance))
    if question.unit:
        unit = _add(_add(made, "units"), "unit")
        _all(unit, {"multiplier": 1, "unit_name": question.unit})
    # A unit may be typed behind the number, and need not (showunits 0); 3: no unit.
    some = {"unitgradingtype": 0, "unitpenalty": 0.1, "unitsleft": 0}
    _all(made, some | {"showunits": 0 if question.unit else 3})


def _text(above: ET.Element, tag: str, text: str, **attributes: object) -> ET.Element:
    """Add an element whose text is HTML."""
    made = _add(above, tag, **attributes, format="html")
    _add(made, "text", text)
    return made


def _all(above: ET.Element, texts: Mapping[str, object]) -> None:
    """Add some elements with a text each."""
    for tag, text in texts.items():
        _add(above, tag, text)


def _add(
    above: ET.Element, tag: str, text: object = "", **attributes: object
) -> ET.Element:
    """Add an element with a text."""
    words = {name: checked(str(value)) for name, value in attributes.items()}
    made = ET.SubElement(above, tag, words)
    made.text = checked(str(text)) or None
    return made


def _written(root: ET.Element) -> str:
    written = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{written}\n'


# --- QTI 2.1 ---

QTI = "http://www.imsglobal.org/xsd/imsqti_v2p1"
PACKAGE = "http://www.imsglobal.org/xsd/imscp_v1p1"
FIRST_DATE = (1980, 1, 1, 0, 0, 0)  # of a zip; a file of today would differ tomorrow


def qti(name: str, questions: Iterable[Question]) -> bytes:
    """Write questions as a content package: an item each, figures, the manifest."""
    manifest = ET.Element("manifest", xmlns=PACKAGE, identifier=f"pgm-lab-{name}")
    metadata = _add(manifest, "metadata")
    _add(metadata, "schema", "QTIv2.1 Package")
    _add(metadata, "schemaversion", "1.0.0")
    _add(manifest, "organizations")
    resources = _add(manifest, "resources")
    files: dict[str, bytes] = {}
    for question in questions:
        path = f"{key(question)}.xml"
        files[path] = _written(item(question)).encode()
        kind = {"type": "imsqti_item_xmlv2p1", "href": path}
        resource = _add(resources, "resource", identifier=f"r-{key(question)}", **kind)
        _add(resource, "file", href=path)
        picture = getattr(question, "picture", None)
        if picture:
            files[f"images/{picture.name}"] = picture.png
            _add(resource, "file", href=f"images/{picture.name}")
    files = {"imsmanifest.xml": _written(manifest).encode(), **files}
    made = BytesIO()
    with ZipFile(made, "w") as package:
        for path, content in files.items():
            package.writestr(ZipInfo(path, FIRST_DATE), content, ZIP_DEFLATED)
    return made.getvalue()


def item(question: Question) -> ET.Element:
    """Return one question as an item: declared, shown, judged and commented."""
    made = ET.Element("assessmentItem", xmlns=QTI)
    made.attrib |= {"identifier": key(question), "title": title(question)}
    made.attrib |= {"adaptive": "false", "timeDependent": "false"}
    choice = isinstance(question, ChoiceQuestion)
    response = _declared(
        made, "response", "RESPONSE", "identifier" if choice else "float"
    )
    score = _declared(made, "outcome", "SCORE", "float")
    _add(_add(score, "defaultValue"), "value", 0)
    _declared(made, "outcome", "FEEDBACK", "identifier")
    _into(_add(made, "itemBody"), body(question, "images/{}"))
    _add(made, "responseProcessing")
    correct = _add(response, "correctResponse")
    if isinstance(question, ChoiceQuestion):
        right = [one.right for one in question.choices].index(True) + 1
        _add(correct, "value", f"choice{right}")
        _qti_choices(made, question)
    else:
        _add(correct, "value", fixed(question.answer))
        _qti_numbers(made, question)
    return made


def _qti_choices(made: ET.Element, question: ChoiceQuestion) -> None:
    shown, judged = made[-2:]
    asked = {"responseIdentifier": "RESPONSE", "shuffle": "true", "maxChoices": 1}
    choices = _add(shown, "choiceInteraction", **asked)
    for k, one in enumerate(question.choices, start=1):
        _add(choices, "simpleChoice", one.text, identifier=f"choice{k}")
        _said(made, f"choice{k}", f"<p>{escape(one.feedback, quote=False)}</p>")
    rule = _add(_add(judged, "responseCondition"), "responseIf")
    same = _add(rule, "match")
    _add(same, "variable", identifier="RESPONSE")
    _add(same, "correct", identifier="RESPONSE")
    _set(rule, "SCORE", "float", 1)
    given = _add(judged, "setOutcomeValue", identifier="FEEDBACK")
    _add(given, "variable", identifier="RESPONSE")


def _qti_numbers(made: ET.Element, question: Variant) -> None:
    shown, judged = made[-2:]
    asked = {"responseIdentifier": "RESPONSE", "expectedLength": 12}
    _add(_add(shown, "p"), "textEntryInteraction", **asked)
    condition = _add(judged, "responseCondition")
    solution = html(question.solution)
    rule = _near(condition, "responseIf", question.answer, question.tolerance)
    _set(rule, "SCORE", "float", 1)
    _set(rule, "FEEDBACK", "identifier", "right")
    _said(made, "right", solution)
    for k, (words, value) in enumerate(question.slips.items(), start=1):
        rule = _near(condition, "responseElseIf", value, question.tolerance)
        _set(rule, "FEEDBACK", "identifier", f"slip{k}")
        _said(made, f"slip{k}", slip(words) + solution)
    _set(_add(condition, "responseElse"), "FEEDBACK", "identifier", "wrong")
    _said(made, "wrong", solution)


def _declared(above: ET.Element, what: str, name: str, kind: str) -> ET.Element:
    given = {"identifier": name, "cardinality": "single", "baseType": kind}
    return _add(above, f"{what}Declaration", **given)


def _near(above: ET.Element, tag: str, value: float, tolerance: float) -> ET.Element:
    """Add a rule for answers that are near to a value."""
    rule = _add(above, tag)
    mode = {"toleranceMode": "exact"}
    if tolerance:
        mode = {
            "toleranceMode": "absolute",
            "tolerance": " ".join(2 * [fixed(tolerance)]),
        }
    same = _add(rule, "equal", **mode)
    _add(same, "variable", identifier="RESPONSE")
    _add(same, "baseValue", fixed(value), baseType="float")
    return rule


def _set(rule: ET.Element, outcome: str, kind: str, value: object) -> None:
    """Let a rule give an outcome its value."""
    given = _add(rule, "setOutcomeValue", identifier=outcome)
    _add(given, "baseValue", value, baseType=kind)


def _said(item: ET.Element, name: str, text: str) -> None:
    """Add what is said after an answer."""
    shown = {"outcomeIdentifier": "FEEDBACK", "identifier": name, "showHide": "show"}
    _into(_add(item, "modalFeedback", **shown), text)


def _into(above: ET.Element, text: str) -> None:
    """Put XHTML into an element."""
    above.extend(ET.fromstring(f"<div>{checked(text)}</div>"))
