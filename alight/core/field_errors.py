"""Errors of fields, as pydantic reports them, in our words."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from alight.core.errors import Issue, join_path, show_value, unknown_name


def translate(spec: type[BaseModel], error: ValidationError) -> list[Issue]:
    """Put pydantic's errors in our words: one issue each, paths relative to the description."""
    return [
        Issue(
            join_path(*detail["loc"]),
            _message(spec, detail),
            about_key=detail["type"] == "extra_forbidden",
        )
        for detail in error.errors(include_url=False)
    ]


def _message(spec: type[BaseModel], detail: Mapping[str, Any]) -> str:
    kind, value = detail["type"], detail["input"]
    fields = [name for name in spec.model_fields if name != "type"]
    if kind == "alight":
        return detail["ctx"]["message"]
    if kind == "extra_forbidden":
        return unknown_name("key", str(detail["loc"][-1]), fields, listed_as="keys")
    if kind == "missing":
        return f"is missing  (keys: {', '.join(fields)})"
    if kind == "literal_error":
        return _choice_message(value, re.findall(r"'([^']*)'", detail["ctx"]["expected"]))
    nouns = {"string_type": "a text", "bool_type": "true or false", "dict_type": "a mapping"}
    if kind in nouns:
        return f"must be {nouns[kind]}, got {show_value(value)}"
    if kind == "is_instance_of":
        return f"must be a {detail['ctx']['class'].lower()}, got {show_value(value)}"
    return f"{detail['msg']}, got {show_value(value)}"


def _choice_message(value: object, choices: list[str]) -> str:
    near = difflib.get_close_matches(str(value)[:80], choices, n=1)
    hint = f'; did you mean "{near[0]}"?' if near else ""
    return f"must be one of {', '.join(choices)}, got {show_value(value)}{hint}"
