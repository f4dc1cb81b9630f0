"""The small faults that a module allows, found in its syntax."""

import ast
from typing import NamedTuple

LOOKS = "alpha c color colors edgecolors facecolors figsize fontsize ha layout"
LOOKS += (
    " linewidth linewidths loc marker markersize markeredgewidth pad rotation s size va"
)
LOOKS += " zorder label labelpad height_ratios width_ratios hspace wspace"

CLEARANCE = "set_axis_off set_visible apply_aspect tick_params margins grid".split()

COMPARED = {"<": ("<=", ">"), ">": (">=", "<"), "<=": ("<", ">="), ">=": (">", "<=")}
COMPARED |= {"==": ("!=",), "!=": ("==",), "is": ("is not",), "is not": ("is",)}
COMPARED |= {"in": ("not in",), "not in": ("in",)}
SYMBOLS = {ast.Lt: "<", ast.Gt: ">", ast.LtE: "<=", ast.GtE: ">=", ast.Eq: "=="}
SYMBOLS |= {ast.NotEq: "!=", ast.Is: "is", ast.IsNot: "is not", ast.In: "in"}
SYMBOLS |= {ast.NotIn: "not in", ast.And: "and", ast.Or: "or", ast.Add: "+"}
SYMBOLS |= {ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
SYMBOLS |= {ast.BitAnd: "&", ast.BitOr: "|"}
EXCHANGED = {"+": "-", "-": "+", "*": "/", "/": "*", "**": "*", "&": "|", "|": "&"}
EXCHANGED |= {"and": "or", "or": "and"}
TWINS = [("any", "all"), ("min", "max"), ("minimum", "maximum"), ("argmin", "argmax")]
TWINS += [("sin", "cos"), ("arcsin", "arccos"), ("floor", "ceil"), ("ones", "zeros")]
TWINS += [("triu", "tril"), ("sum", "mean"), ("nanmin", "nanmax"), ("hstack", "vstack")]
TWIN = dict(TWINS) | {b: a for a, b in TWINS}
DROPPED = {"T": "a transpose", "copy": "a copy"}
UNWRAPPED = {"abs": "an absolute value", "sqrt": "a square root"}
UNORDERED = "array_equal broadcast_shapes equal hypot isclose isinstance logical_and"
UNORDERED += " logical_or max maximum min minimum issubdtype hasattr getattr isdisjoint"


class Fault(NamedTuple):
    """A piece of one line, in bytes from its beginning, and what to put there."""

    line: int
    begin: int
    end: int
    new: str
    kind: str


class _Sites(ast.NodeVisitor):
    """Collects the faults that a module allows."""

    def __init__(self, text: str, drawing: bool) -> None:
        self.lines = [line.encode() for line in text.splitlines()]
        self.drawing = drawing
        self.found: list[Fault] = []
        self.within = ""  # of what a number is part of: an index, an axis

    # How to say where

    def put(self, node: ast.AST, new: str, kind: str) -> None:
        """Replace a whole node, if it stands on one line."""
        if node.lineno == node.end_lineno:
            self.put_at(node.lineno, node.col_offset, node.end_col_offset, new, kind)

    def put_at(self, line: int, begin: int, end: int, new: str, kind: str) -> None:
        self.found.append(Fault(line, begin, end, new, kind))

    def text(self, node: ast.AST) -> str:
        """The text of a node of one line, else nothing."""
        if node.lineno != node.end_lineno:
            return ""
        line = self.lines[node.lineno - 1]
        return line[node.col_offset : node.end_col_offset].decode()

    def put_between(self, left, right, symbol: str, new: str, kind: str) -> None:
        """Replace the operator between two nodes."""
        for number in range(left.end_lineno, right.lineno + 1):
            line = self.lines[number - 1]
            begin = left.end_col_offset if number == left.end_lineno else 0
            end = right.col_offset if number == right.lineno else len(line)
            code = line[begin:end].split(b"#")[0]
            if (at := code.find(symbol.encode())) >= 0:
                start = begin + at
                self.put_at(number, start, start + len(symbol), new, kind)
                return

    def swap(self, first, second, kind: str) -> None:
        """Exchange two nodes on one line."""
        a, b = self.text(first), self.text(second)
        if a and b and a != b and first.lineno == second.lineno:
            line = self.lines[first.lineno - 1]
            middle = line[first.end_col_offset : second.col_offset].decode()
            begin, end = first.col_offset, second.end_col_offset
            self.put_at(first.lineno, begin, end, b + middle + a, kind)

    # What is looked into, and what is not

    def visit_Raise(self, node: ast.Raise) -> None:
        pass

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        pass

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_arguments(self, node: ast.arguments) -> None:
        for default in [*node.defaults, *node.kw_defaults]:
            if default is not None:
                self.visit(default)

    def visit_function(self, node) -> None:
        for part in [*node.decorator_list, node.args, *node.body]:
            self.visit(part)

    visit_FunctionDef = visit_AsyncFunctionDef = visit_function

    def visit_Assign(self, node: ast.Assign) -> None:
        named = [target.id for target in node.targets if isinstance(target, ast.Name)]
        if "__all__" in named:
            return
        self.generic_visit(node)
        call = node.value
        if isinstance(call, ast.Call) and call.args and checks(call):
            self.put(call, self.text(call.args[0]), "a check of an argument removed")

    def visit_Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Call):
            return
        name = getattr(node.value.func, "attr", "")
        if self.drawing and name in CLEARANCE:
            return
        if node.lineno == node.end_lineno:
            self.put(node, "pass", "a call removed")
        else:
            begin = node.col_offset
            self.put_at(node.lineno, begin, begin, "False and ", "a call removed")
        self.generic_visit(node)

    # The faults

    def visit_Compare(self, node: ast.Compare) -> None:
        parts = [node.left, *node.comparators]
        for left, right, op in zip(parts, parts[1:], node.ops):
            symbol = SYMBOLS[type(op)]
            for new in COMPARED[symbol]:
                self.put_between(left, right, symbol, new, "a comparison")
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        symbol = SYMBOLS[type(node.op)]
        for left, right in zip(node.values, node.values[1:]):
            self.put_between(left, right, symbol, EXCHANGED[symbol], "and, or")
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        symbol = SYMBOLS.get(type(node.op))
        sides = (node.left, node.right)
        look = self.drawing and has_number(node)
        if isinstance(node.op, ast.MatMult):
            self.swap(*sides, "the order of a product")
        elif symbol and not look and not any(map(is_text, sides)):
            self.put_between(*sides, symbol, EXCHANGED[symbol], "arithmetic")
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        symbol = SYMBOLS.get(type(node.op))
        if symbol and not is_text(node.value):
            new = EXCHANGED[symbol]
            self.put_between(node.target, node.value, symbol, new, "arithmetic")
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        names = {ast.USub: "a sign", ast.Not: "not", ast.Invert: "not"}
        if type(node.op) in names and not (self.drawing and is_number(node)):
            kind = names[type(node.op)] + " dropped"
            self.put(node, self.text(node.operand) or "", kind)
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        value = node.value
        if self.drawing and not self.within:
            return
        if isinstance(value, bool):
            self.put(node, str(not value), "a truth value")
        elif isinstance(value, int):
            kind = self.within or "a number"
            for new in (value + 1, value - 1):
                self.put(node, f"{new}" if new >= 0 else f"({new})", kind)
        elif isinstance(value, float):
            for new in (10 * value, value / 10) if value else (1.0,):
                self.put(node, f"{new:g}" if new != int(new) else f"{new}", "a number")

    def visit_Subscript(self, node: ast.Subscript) -> None:
        self.visit(node.value)
        before, self.within = self.within, "an index"
        self.visit(node.slice)
        self.within = before

    def visit_Attribute(self, node: ast.Attribute) -> None:
        self.twin(node, node.attr)
        if node.attr == "T":
            begin = node.value.end_col_offset
            if node.value.end_lineno == node.end_lineno:
                end = node.end_col_offset
                self.put_at(node.end_lineno, begin, end, "", "a transpose dropped")
        self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> None:
        self.twin(node, node.id)

    def twin(self, node, name: str) -> None:
        """Exchange any and all, sin and cos, ..."""
        if name in TWIN:
            end = node.end_col_offset
            new = TWIN[name]
            self.put_at(node.end_lineno, end - len(name), end, new, f"{new} for {name}")

    def visit_condition(self, node) -> None:
        if self.text(node.test):
            looped = isinstance(node, ast.While)
            for new in ("False",) if looped else ("True", "False"):
                self.put(node.test, new, "a condition forced")
        self.generic_visit(node)

    def visit_If(self, node: ast.If) -> None:
        if getattr(node.test, "id", "") != "TYPE_CHECKING":
            self.visit_condition(node)

    visit_IfExp = visit_While = visit_condition

    def visit_comprehension(self, node: ast.comprehension) -> None:
        for test in node.ifs:
            self.put(test, "True", "a condition forced")
        self.generic_visit(node)

    def visit_Return(self, node: ast.Return) -> None:
        if isinstance(node.value, ast.Tuple):
            for pair in zip(node.value.elts, node.value.elts[1:]):
                self.swap(*pair, "a field that is returned")
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if name == "copy" and not node.args and isinstance(node.func, ast.Attribute):
            begin, end = node.func.value.end_col_offset, node.end_col_offset
            if node.func.value.end_lineno == node.end_lineno:
                self.put_at(node.end_lineno, begin, end, "", "a copy dropped")
        if name in UNWRAPPED and len(node.args) == 1:
            new = f"({self.text(node.args[0])})"
            if len(new) > 2:
                self.put(node, new, f"{UNWRAPPED[name]} dropped")
        if name not in UNORDERED.split():
            for pair in zip(node.args, node.args[1:]):
                if not any(isinstance(a, ast.Starred) or is_text(a) for a in pair):
                    self.swap(*pair, "the order of arguments")
        if name[:1].isupper():
            for one, other in zip(node.keywords, node.keywords[1:]):
                if self.text(one.value) and self.text(other.value) and one.arg:
                    new = self.text(other.value)
                    self.put(one.value, new, "a field that is returned")
        self.visit(node.func)
        for argument in node.args:
            self.visit(argument)
        for keyword in node.keywords:
            if self.drawing and keyword.arg in LOOKS.split():
                continue
            before, self.within = self.within, self.within
            if keyword.arg in ("axis", "axis1", "axis2"):
                self.within = "an axis"
            self.visit(keyword.value)
            self.within = before


def is_number(node: ast.AST) -> bool:
    """Whether a node is a number as it stands."""
    if isinstance(node, ast.UnaryOp):
        node = node.operand
    return isinstance(node, ast.Constant) and not isinstance(node.value, str)


def has_number(node: ast.AST) -> bool:
    """Whether a term has a number as it stands somewhere in its arithmetic."""
    if isinstance(node, ast.BinOp):
        return has_number(node.left) or has_number(node.right)
    return is_number(node)


def is_text(node: ast.AST) -> bool:
    """Whether a node is a text as it stands."""
    literal = isinstance(node, ast.Constant) and isinstance(node.value, str)
    return literal or isinstance(node, ast.JoinedStr)


def checks(call: ast.Call) -> bool:
    """Whether a call checks an argument: a function of the door _validate."""
    owner = getattr(call.func, "value", None)
    return getattr(owner, "id", "") == "_validate"


def sites(text: str, drawing: bool) -> list[Fault]:
    """All faults that the text of a module allows, each once.

    What draws (`drawing`) has numbers and looks that are a matter of taste.
    """
    found = _Sites(text, drawing)
    found.visit(ast.parse(text))
    return list(dict.fromkeys(found.found))
