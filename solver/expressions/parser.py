"""From text to a syntax tree, by operator precedence (the precedence of Python).

::

    truth       = conjunction {"or" conjunction}
    conjunction = inversion {"and" inversion}
    inversion   = "not" inversion | comparison
    comparison  = sum {("<" | "<=" | ">" | ">=" | "==" | "!=") sum}      # a < b < c means a < b and b < c
    sum         = product {("+" | "-") product}
    product     = sign {("*" | "/") sign}
    sign        = ("+" | "-") sign | power
    power       = atom ["**" sign]
    atom        = number | name | function "(" truth {"," truth} ")" | "(" truth ")"    # where takes a comparison first
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions.functions import CONSTANTS, FUNCTIONS, HINTS, WHERE
from geoswarm.solver.expressions.nodes import (
    Call,
    Comparison,
    Constant,
    Junction,
    Name,
    Negation,
    Node,
    Operation,
    depth,
    is_truth,
    negated,
)
from geoswarm.solver.words import did_you_mean

__all__ = ["MAX_DEPTH", "MAX_LENGTH", "parse_tree"]

MAX_LENGTH = 1000
"""Characters that an expression may have."""

MAX_DEPTH = 50
"""Levels of nesting that an expression may have."""

_TOKEN = re.compile(
    r"""\s*(?:
        (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
      | (?P<name>[^\W\d]\w*(?:\.[^\W\d]\w*)*)
      | (?P<symbol>\*\*|<=|>=|==|!=|//|&&|\|\||<>|[-+*/<>(),=^%&|!~\[\]{}])
    )""",
    re.VERBOSE,
)

_COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
_WORDS = ("and", "or", "not")
_SYMBOL_HINTS = {
    "^": "write a**b for a power",
    "=": "write == to compare",
    "<>": "write != to compare",
    "//": "only + - * / ** are known",
    "%": "only + - * / ** are known",
    "&": "write and",
    "&&": "write and",
    "|": "write or",
    "||": "write or",
    "!": "write not",
    "~": "write not",
    "[": "write ( )",
    "]": "write ( )",
    "{": "write ( )",
    "}": "write ( )",
}


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    column: int

    def __str__(self) -> str:
        return f"'{self.text}' at character {self.column}"


def parse_tree(text: str) -> Node:
    """Parse an expression.

    Raises
    ------
    ExpressionError
        The message names the piece that is wrong, its place, and what could be written.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"expression has {len(text)} characters; at most {MAX_LENGTH} are accepted")
    tokens = _tokens(text)
    if len(tokens) == 1:
        raise ExpressionError("expression is empty; write for example 0.5 * lambda_star")
    return _Parser(tokens).whole()


def _tokens(text: str) -> list[_Token]:
    tokens, position, end = [], 0, len(text.rstrip())
    while position < end:
        match = _TOKEN.match(text, position, end)
        if match is None:
            column = position + len(text[position:]) - len(text[position:].lstrip())
            raise ExpressionError(f"unexpected {text[column]!r} at character {column + 1}")
        kind = match.lastgroup or ""
        token = _Token(kind, match.group(kind), match.start(kind) + 1)
        if kind == "symbol" and token.text in _SYMBOL_HINTS:
            raise ExpressionError(f"unexpected {token}; {_SYMBOL_HINTS[token.text]}")
        tokens.append(token)
        position = match.end()
    return [*tokens, _Token("end", "", end + 1)]


class _Parser:
    def __init__(self, tokens: list[_Token]) -> None:
        self._tokens = tokens
        self._index = 0
        self._open = 0

    def whole(self) -> Node:
        node = self._truth()
        if self._next.kind != "end":
            raise self._unexpected("an operator")
        if depth(node) > MAX_DEPTH:
            raise _too_deep()
        return node

    @property
    def _next(self) -> _Token:
        return self._tokens[self._index]

    def _take(self) -> _Token:
        token = self._tokens[self._index]
        self._index += 1
        return token

    def _at(self, *texts: str) -> bool:
        return self._next.kind in ("symbol", "name") and self._next.text in texts

    def _unexpected(self, wanted: str) -> ExpressionError:
        if self._next.kind == "end":
            return ExpressionError(f"expression ends where {wanted} is expected")
        return ExpressionError(f"unexpected {self._next}; {wanted} is expected there")

    def _truth(self) -> Node:
        return self._junction("or", self._conjunction)

    def _conjunction(self) -> Node:
        return self._junction("and", self._inversion)

    def _junction(self, word: str, operand: Callable[[], Node]) -> Node:
        node = operand()
        if not self._at(word):
            return node
        operands = [self._checked_truth(node, word)]
        while self._at(word):
            self._take()
            operands.append(self._checked_truth(operand(), word))
        return Junction(word, tuple(operands))

    def _inversion(self) -> Node:
        if not self._at("not"):
            return self._comparison()
        self._take()
        with self._deeper():
            return negated(self._checked_truth(self._inversion(), "not"))

    def _comparison(self) -> Node:
        left = self._sum()
        if not self._at(*_COMPARISONS):
            return left
        parts: list[Node] = []
        while self._at(*_COMPARISONS):
            symbol = self._take().text
            right = self._sum()
            parts.append(Comparison(symbol, self._checked_number(left, symbol), self._checked_number(right, symbol)))
            left = right
        return parts[0] if len(parts) == 1 else Junction("and", tuple(parts))

    def _sum(self) -> Node:
        return self._operations(("+", "-"), self._product)

    def _product(self) -> Node:
        return self._operations(("*", "/"), self._sign)

    def _operations(self, symbols: tuple[str, ...], operand: Callable[[], Node]) -> Node:
        node = operand()
        while self._at(*symbols):
            symbol = self._take().text
            node = Operation(symbol, self._checked_number(node, symbol), self._checked_number(operand(), symbol))
        return node

    def _sign(self) -> Node:
        if not self._at("+", "-"):
            return self._power()
        symbol = self._take().text
        with self._deeper():
            operand = self._checked_number(self._sign(), symbol)
        return Negation(operand) if symbol == "-" else operand

    def _power(self) -> Node:
        base = self._atom()
        if not self._at("**"):
            return base
        self._take()
        with self._deeper():
            exponent = self._sign()
        return Operation("**", self._checked_number(base, "**"), self._checked_number(exponent, "**"))

    def _atom(self) -> Node:
        token = self._next
        if token.kind == "number":
            return self._number()
        if self._at("("):
            self._take()
            with self._deeper():
                node = self._truth()
            self._close("an operator or ')'")
            return node
        if token.kind != "name" or token.text in _WORDS:
            raise self._unexpected("a number, a name or '('")
        self._take()
        if self._at("("):
            return self._call(token)
        if token.text in FUNCTIONS:
            raise ExpressionError(f"{token} is a function; write {token.text}(...)")
        if token.text in CONSTANTS:
            return Constant(CONSTANTS[token.text])
        return Name(token.text)

    def _number(self) -> Node:
        token = self._take()
        value = float(token.text)
        if not math.isfinite(value):
            raise ExpressionError(f"number {token} is too large; the largest is 1.79e308")
        following = self._next
        if following.kind in ("name", "number") and following.column == token.column + len(token.text):
            piece = token.text + following.text
            raise ExpressionError(f"'{piece}' at character {token.column} is not a number; write * to multiply")
        return Constant(value)

    def _call(self, token: _Token) -> Node:
        function = FUNCTIONS.get(token.text)
        if function is None:
            raise ExpressionError(_unknown_function(token.text))
        self._take()
        if token.text == WHERE:
            return self._choice(token)
        with self._deeper():
            arguments = [self._checked_number(self._truth(), token.text)]
            while self._at(","):
                self._take()
                arguments.append(self._checked_number(self._truth(), token.text))
        self._close("an operator, ',' or ')'")
        if function.most_arguments is not None and len(arguments) > function.most_arguments:
            raise ExpressionError(f"{token} takes one argument, got {len(arguments)}")
        return Call(token.text, tuple(arguments))

    def _choice(self, token: _Token) -> Node:
        with self._deeper():
            condition = self._checked_truth(self._truth(), token.text)
            values: list[Node] = []
            while self._at(","):
                self._take()
                values.append(self._checked_number(self._truth(), token.text))
        self._close("an operator, ',' or ')'")
        if len(values) != 2:
            raise ExpressionError(f"{token} takes a comparison and two numbers: where(a > b, c, d)")
        return Call(token.text, (condition, negated(condition), *values))

    def _close(self, wanted: str) -> None:
        if not self._at(")"):
            raise self._unexpected(wanted)
        self._take()

    def _deeper(self) -> _Parser:
        return self

    def __enter__(self) -> None:
        self._open += 1
        if self._open > MAX_DEPTH:
            raise _too_deep()

    def __exit__(self, *_: object) -> None:
        self._open -= 1

    @staticmethod
    def _checked_number(node: Node, user: str) -> Node:
        if is_truth(node):
            raise ExpressionError(f"'{user}' needs numbers, but got a comparison")
        return node

    @staticmethod
    def _checked_truth(node: Node, user: str) -> Comparison | Junction:
        if isinstance(node, Comparison | Junction):
            return node
        raise ExpressionError(f"'{user}' needs comparisons such as a > b, but got a number")


def _too_deep() -> ExpressionError:
    return ExpressionError(
        f"expression is nested too deeply or has too many terms in a row; at most {MAX_DEPTH} are accepted"
    )


def _unknown_function(name: str) -> str:
    known = ", ".join(FUNCTIONS)
    hint = f"; {HINTS[name]}" if name in HINTS else did_you_mean(name, FUNCTIONS)
    return f"unknown function '{name}'{hint}; known: {known}"
