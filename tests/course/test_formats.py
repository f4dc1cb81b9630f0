"""Read back, field by field, as the documentation of each format says."""

import base64
import csv
import re
import xml.etree.ElementTree as ET
from collections import Counter
from html import unescape
from io import BytesIO
from zipfile import ZipFile

import pytest

from pgm_book.course import formats, quiz
from pgm_book.course.numbers import Variant
from pgm_book.course.questions import Choice, ChoiceQuestion, Picture, html, left_out
from pgm_book.make.environment import ROOT

NASTY = (
    "a ~ b = c # d { e } f : g \\ h \\neq \\nu // $CATEGORY: x -> %50% ]]> & < > \" '"
)
PNG = Picture("p.png", b"\x89PNG=:{}", 'alt "x" <y> & ~ = # {z}: \\')
CHOICES = (Choice("%" + NASTY, False, NASTY), Choice("φ ≥ 0°", True, "√ = {x}"))
TEXT = f"`{NASTY}`\n\n$\\nu = \\{{a\\}}$ é\n\n1. x"
ASKED = ChoiceQuestion("1.1", "Of: {signs}", TEXT, CHOICES, PNG)
NUMBER = Variant(
    "1.a.01", "N = 1", "How $x < 1$ {y}?\n\nAnswer.", -1.25, 0.01, "µm", 2,
    "Since $y = \\frac{1}{2}$: $-1.25$.", {"the ~sign~ = #2": 1.25, "b": 1e-7}, {},
)  # fmt: skip
ALL = {"1 One/choices": [ASKED], "1 One/numbers/a": [NUMBER]}


def read_gift(text):
    """Questions of a GIFT file: blocks between empty lines, escaped by a backslash."""
    found, category = [], ""
    for block in text.strip().split("\n\n"):
        if block.startswith("$CATEGORY: "):
            category = block.removeprefix("$CATEGORY: ")
            continue
        (number,) = re.findall(r"^// \[id:(\S+)\]$", block, re.MULTILINE)
        block = block.partition("\n")[2].replace("\n", " ")
        # A sign that is escaped becomes one that nothing looks for.
        hidden = re.sub(r"\\(.)", lambda m: chr(0xE000 + ord(m[1])), block)
        one = re.fullmatch(r"::(.*?)::\[html\]([^{}]*)\{([^{}]*)\}", hidden)
        answers, _, solution = one[3].partition("####")
        said = one[1] + one[2] + solution + "".join(re.findall("#([^=~#]*)", answers))
        assert not set("~=#{}:") & set(said), "a sign is not escaped"
        weights = re.findall("[=~](%)", answers)
        assert not weights or answers.startswith("#"), "a choice begins with a weight"
        numeric = answers.startswith("#")
        parts = re.findall(r"([=~])([^=~#]*(?:%\d+%[^=~#]*)?)(?:#([^=~#]*))?", answers)
        found.append(
            {
                "id": number,
                "category": category,
                "title": plain(one[1]),
                "text": plain(one[2]),
                "numeric": numeric,
                "answers": [tuple(plain(x) for x in part) for part in parts],
                "solution": plain(solution),
            }
        )
    return found


def plain(text):
    shown = re.sub("[\ue000-\ue0ff]", lambda m: chr(ord(m[0]) - 0xE000), text)
    return shown.strip()


def one_line(text):
    return re.sub(r"\s*\n\s*", " ", text)


def test_gift_of_nasty_questions():
    choice, number = read_gift(formats.gift(ALL))
    assert choice["category"] == "pgm_lab/1 One/choices"
    assert (choice["id"], choice["title"]) == ("pgm-1.1", "1.1 Of: {signs}")
    uri = "data:image/png;base64," + base64.b64encode(PNG.png).decode()
    assert (
        choice["text"] == one_line(formats.body(ASKED, uri)) and uri in choice["text"]
    )
    answers = {unescape(a): (sign, unescape(f)) for sign, a, f in choice["answers"]}
    assert answers == {
        one.text: ("=" if one.right else "~", one.feedback) for one in CHOICES
    }
    assert number["numeric"] and number["solution"] == html(NUMBER.solution)
    assert number["answers"][0][:2] == ("=", "-1.25:0.01")
    assert [a for _, a, _ in number["answers"][1:]] == ["%0%1.25:0.01", "%0%0:0.01"]
    assert "the ~sign~ = #2" in number["answers"][1][2]


def test_moodle_xml_of_nasty_questions():
    quiz = ET.fromstring(formats.moodle(ALL))
    category, choice, _, number = quiz.findall("question")
    assert category.get("type") == "category"
    assert category.findtext("category/text") == "$course$/top/pgm_lab/1 One/choices"
    assert choice.get("type") == "multichoice"
    assert choice.findtext("name/text") == "1.1 Of: {signs}"
    assert choice.findtext("idnumber") == "pgm-1.1"
    assert choice.findtext("single") == choice.findtext("shuffleanswers") == "true"
    text = choice.find("questiontext")
    assert text.findtext("text") == formats.body(ASKED, "@@PLUGINFILE@@/{}")
    assert base64.b64decode(text.findtext("file")) == PNG.png
    assert text.find("file").attrib == {
        "name": "p.png", "path": "/", "encoding": "base64"
    }  # fmt: skip
    assert [
        [a.get("fraction"), *map(unescape, [a.findtext("text"), a.findtext("*/text")])]
        for a in choice.findall("answer")
    ] == [["100" if c.right else "0", c.text, c.feedback] for c in CHOICES]
    assert number.get("type") == "numerical"
    assert number.findtext("generalfeedback/text") == html(NUMBER.solution)
    assert [
        (a.get("fraction"), float(a.findtext("text")), float(a.findtext("tolerance")))
        for a in number.findall("answer")
    ] == [("100", -1.25, 0.01), ("0", 1.25, 0.01), ("0", 0, 0.01)]
    assert number.findtext("units/unit/unit_name") == "µm"
    assert number.findtext("units/unit/multiplier") == "1"
    assert number.findtext("showunits") == "0"  # a unit may be typed
    assert number.findtext("unitgradingtype") == "0"  # and is not graded


def test_qti_of_nasty_questions():
    package = ZipFile(BytesIO(formats.qti("1", [ASKED, NUMBER])))
    assert package.testzip() is None and package.namelist()[0] == "imsmanifest.xml"
    cp = {"": formats.PACKAGE}
    manifest = ET.fromstring(package.read("imsmanifest.xml"))
    files = [one.get("href") for one in manifest.iterfind(".//file", cp)]
    assert sorted([*files, "imsmanifest.xml"]) == sorted(package.namelist())
    for resource in manifest.iterfind(".//resource", cp):
        assert resource.get("type") == "imsqti_item_xmlv2p1"
    assert package.read("images/p.png") == PNG.png
    q = {"": formats.QTI}
    choice = ET.fromstring(package.read("pgm-1.1.xml"))
    order = [one.tag.rpartition("}")[2] for one in choice]
    assert order[:6] == [
        "responseDeclaration", "outcomeDeclaration", "outcomeDeclaration",
        "itemBody", "responseProcessing", "modalFeedback",
    ]  # fmt: skip
    interaction = choice.find(".//choiceInteraction", q)
    assert interaction.get("shuffle") == "true" and interaction.get("maxChoices") == "1"
    shown = {one.get("identifier"): one.text for one in interaction}
    assert list(shown.values()) == [one.text for one in CHOICES]
    right = choice.findtext("responseDeclaration/correctResponse/value", namespaces=q)
    assert shown[right] == "φ ≥ 0°"
    said = {
        one.get("identifier"): "".join(one.itertext())
        for one in choice.iterfind("modalFeedback", q)
    }
    assert said == {k: c.feedback for k, c in zip(shown, CHOICES)}
    assert choice.find(".//img", q).attrib == {"src": "images/p.png", "alt": PNG.alt}
    number = ET.fromstring(package.read("pgm-1.a.01.xml"))
    kind = number.find("responseDeclaration", q)
    assert (kind.get("baseType"), kind.get("cardinality")) == ("float", "single")
    assert number.find(".//textEntryInteraction", q).get("responseIdentifier") == (
        kind.get("identifier")
    )


@pytest.mark.parametrize(
    ("response", "score", "feedback"),
    [
        (-1.245, "1", "right"),
        (1.25, None, "slip1"),
        (0, None, "slip2"),
        (7, None, "wrong"),
    ],
)
def test_qti_judges_a_number(response, score, feedback):
    """The rules, read as the information model says: the first that holds."""
    item = ET.fromstring(ET.tostring(formats.item(NUMBER)))
    q = {"": formats.QTI}
    for rule in item.find("responseProcessing/responseCondition", q):
        near = rule.find("equal", q)
        if near is not None:
            low, high = map(float, near.get("tolerance").split())
            value = float(near.findtext("baseValue", namespaces=q))
            if not value - low <= response <= value + high:
                continue
        outcome = {
            one.get("identifier"): one.findtext("baseValue", namespaces=q)
            for one in rule.iterfind("setOutcomeValue", q)
        }
        break
    assert outcome.get("SCORE") == score and outcome["FEEDBACK"] == feedback
    said = {one.get("identifier") for one in item.iterfind("modalFeedback", q)}
    assert feedback in said


@pytest.mark.parametrize("sign", ["\0", "\x0b", "\x1b", "\x85", "\ud800", "\uffff"])
def test_control_characters_are_refused(sign):
    one = ChoiceQuestion("1.1", "t", "x", (Choice(f"a{sign}", True, "f"),))
    for write in (formats.gift, formats.moodle):
        with pytest.raises(ValueError, match="control character"):
            write({"c": [one]})
    with pytest.raises(ValueError, match="control character"):
        formats.item(one)


# --- All questions of the book ---


@pytest.fixture(scope="module")
def everything():
    return quiz.categories(ROOT / "notebooks")


@pytest.fixture(scope="module")
def written(everything, tmp_path_factory):
    folder = tmp_path_factory.mktemp("quiz")
    return folder, [path.relative_to(folder).as_posix() for path in
                    quiz.write(ROOT / "notebooks", folder)]  # fmt: skip


# Which elements an element may hold, and its attributes, by the information model.
INLINE = "img em strong code br sub sup textEntryInteraction"
MODEL = {
    "assessmentItem": "responseDeclaration outcomeDeclaration itemBody "
    "responseProcessing modalFeedback @identifier @title @adaptive @timeDependent",
    "responseDeclaration": "correctResponse @identifier @cardinality @baseType",
    "outcomeDeclaration": "defaultValue @identifier @cardinality @baseType",
    "correctResponse": "value",
    "defaultValue": "value",
    "itemBody": "p table ul ol choiceInteraction",
    "modalFeedback": "p table ul ol @outcomeIdentifier @identifier @showHide",
    "choiceInteraction": "simpleChoice @responseIdentifier @shuffle @maxChoices",
    "simpleChoice": "@identifier",
    "textEntryInteraction": "@responseIdentifier @expectedLength",
    "responseProcessing": "responseCondition setOutcomeValue",
    "responseCondition": "responseIf responseElseIf responseElse",
    "responseIf": "match equal setOutcomeValue",
    "responseElseIf": "equal setOutcomeValue",
    "responseElse": "setOutcomeValue",
    "setOutcomeValue": "variable baseValue @identifier",
    "match": "variable correct",
    "equal": "variable baseValue @toleranceMode @tolerance",
    "variable": "@identifier",
    "correct": "@identifier",
    "baseValue": "@baseType",
    "table": "thead tbody",
    "thead": "tr",
    "tbody": "tr",
    "tr": "th td",
    "img": "@src @alt",
    **{one: INLINE for one in "p td th em strong".split()},
}


def misplaced(item):
    """What an item holds where the information model does not allow it."""
    for element in item.iter():
        name = element.tag.rpartition("}")[2]
        allowed = MODEL.get(name, "").split()
        held = [one.tag.rpartition("}")[2] for one in element]
        yield from (
            (name, one)
            for one in [*held, *(f"@{key}" for key in element.keys())]
            if one not in allowed
        )


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def numbers(everything):
    return Counter(
        formats.key(one)
        for here in everything.values()
        for some in here.values()
        for one in some
    )


@pytest.mark.slow
def test_all_questions_are_in_all_formats(everything, written):
    folder, names = written
    expected = numbers(everything)
    tables = (ROOT / "pgm_book").glob("ch*/*predictions.csv")
    asked = {row["prediction"] for path in tables for row in rows(path)}
    choices = len(asked - left_out().keys())
    numbered = sum("/numbers/" in name for here in everything.values() for name in here)
    assert len(expected) == sum(expected.values()) == choices + 50 * numbered
    gift = read_gift((folder / names[0]).read_text(encoding="utf-8"))
    assert Counter(one["id"] for one in gift) == expected
    root = ET.parse(folder / names[1]).getroot()
    found = [one.findtext("idnumber") for one in root if one.get("type") != "category"]
    assert Counter(found) == expected
    items = Counter()
    for name in names[2:]:
        package = ZipFile(folder / name)
        items += Counter(n[:-4] for n in package.namelist() if n.startswith("pgm-"))
        for inner in package.namelist():
            if inner.startswith("pgm-"):
                assert not list(misplaced(ET.fromstring(package.read(inner))))
    assert items == expected


def test_a_category_a_lesson_and_one_for_each_question_with_numbers(everything):
    assert list(everything["1"])[:2] == [
        "1 From pixel to photo/choices",
        "1 From pixel to photo/numbers/The y of a pixel",
    ]
    for number, here in everything.items():
        for name, some in here.items():
            assert name.startswith(f"{number} ") and "//" not in name
            assert len(some) == 50 or name.endswith("/choices")


@pytest.mark.slow
def test_the_same_files_again(written, tmp_path):
    folder, names = written
    assert [path.name for path in quiz.write(ROOT / "notebooks", tmp_path)]
    for name in names:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def test_names_what_is_left_out(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(quiz, "write", lambda *_: iter([tmp_path / "q.xml"]))
    assert quiz.main([]) == 0
    said = capsys.readouterr().out
    assert "q.xml" in said and "left out: 4c.1, since" in said
