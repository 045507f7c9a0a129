"""A page of HTML as a test looks at it: its elements, its text, and whether it is well formed."""

import base64
import json
import re
from html.parser import HTMLParser
from typing import Any

import numpy as np

VOID = {"meta", "img", "input", "br", "link", "hr"}


class Page(HTMLParser):
    """The page's elements with their attributes, its text, and whether it is well formed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag, tag

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]


def carried(source: str) -> Any:
    """What the script of a page works on."""
    text = re.search(r'id="refit-data">(.*?)</script>', source, re.DOTALL)
    assert text
    return unpacked(json.loads(text[1]))


def unpacked(value: Any) -> Any:
    """The same with its columns of numbers as lists."""
    if isinstance(value, dict):
        if set(value) == {"f32"}:
            return np.frombuffer(base64.b64decode(value["f32"]), "<f4").astype(float).tolist()
        return {key: unpacked(each) for key, each in value.items()}
    return [unpacked(each) for each in value] if isinstance(value, list) else value
