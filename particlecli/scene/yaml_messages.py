"""What PyYAML complains about, said plainly: what is wrong in the text and what to write instead."""

from __future__ import annotations

import yaml

_MESSAGES = {
    "mapping values are not allowed in this context": (
        "a colon is out of place; put text that has one in quotes, or the key on a line of its own"
    ),
    "found unexpected end of stream": "this quote is never closed",
    "could not find expected ':'": "a key needs a colon and a space after it",
    "did not find expected key": "this does not line up with the keys above; check indentation and quotes",
    "did not find expected '-' indicator": "this does not line up with the list above; check the indentation",
    "did not find expected ',' or ']'": "this list is not closed; a comma or ] is missing",
    "did not find expected ',' or '}'": "this mapping is not closed; a comma or } is missing",
    "did not find expected node content": "a value is missing; a comma too many, or a bracket not closed",
    "block sequence entries are not allowed in this context": "a list with - must begin on a line of its own",
    "did not find expected <document start>": "this does not belong to the lines above; check indentation",
    "exceeded maximum nesting depth": "this is nested deeper than any scene; is a bracket never closed?",
}
_BEGAN_BEFORE = ("unexpected end of stream", "expected ':'", "',' or ']'", "',' or '}'")
"""Ends of messages about what began where the context, not the problem, is marked."""


def explain(error: yaml.YAMLError, text: str) -> tuple[str, int | None, int | None]:
    """The message for a syntax error, and its line and column from 1 where known."""
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return "this is not valid YAML", None, None
    problem = error.problem or ""
    mark = error.problem_mark
    if error.context_mark is not None and problem.endswith(_BEGAN_BEFORE):
        mark = error.context_mark
    message = _MESSAGES.get(problem)
    if problem == "found character that cannot start any token":
        message = _about_character(text, mark.line, mark.column)
    if message is None:
        message = f"this is not valid YAML: {problem}"
    return message, mark.line + 1, mark.column + 1


def _about_character(text: str, line: int, column: int) -> str:
    lines = text.splitlines()
    character = lines[line][column : column + 1] if line < len(lines) else ""
    if character == "\t":
        return "indent with spaces, not with tabs"
    return f"a value cannot begin with {character}; put it in quotes"
