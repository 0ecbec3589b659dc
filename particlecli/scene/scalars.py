"""What an unquoted word of YAML means: the core schema of YAML 1.2, where numbers are what they look like."""

from __future__ import annotations

import re
from typing import Any

NULL = re.compile(r"~|null|Null|NULL|")
BOOL = re.compile(r"true|True|TRUE|false|False|FALSE")
INT = re.compile(r"[-+]?[0-9]+(?:_[0-9]+)*")
OTHER_BASE = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
FLOAT = re.compile(
    r"[-+]?(?:\.[0-9]+|[0-9]+(?:_[0-9]+)*(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"
    r"|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"
)
LONGEST_INT = 300
"""Digits beyond which a whole number is read as a float: it would not fit into one as it is."""


def resolve(text: str) -> Any:
    """The value of a plain scalar: None, bool, int, float, or the text itself.

    Unlike YAML 1.1, `1e3` is a number, `010` is ten, and `yes`, `on`, `1:30` and `2001-01-01` are text.
    """
    if NULL.fullmatch(text):
        return None
    if BOOL.fullmatch(text):
        return text.lower() == "true"
    if INT.fullmatch(text) and len(text) <= LONGEST_INT:
        return int(text)
    if OTHER_BASE.fullmatch(text) and len(text) <= LONGEST_INT:
        return int(text, 0)
    if FLOAT.fullmatch(text):
        sign_and_name = text.lower().replace(".inf", "inf").replace(".nan", "nan")
        return float(sign_and_name)
    return text
