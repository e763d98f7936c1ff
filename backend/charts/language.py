"""What the server says in English, in another language: from the texts of the page, which are the only ones.

The files of `frontend/i18n` hold one text a line, so that they can be read without running them; the rules by which
a sentence is recognised are those of `frontend/js/sentences.js` and `i18n.js`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Literal

from backend.page import page_folder

Language = Literal["en", "ru"]

_SECTION = re.compile(r"^export (?:const (\w+)|default)\b")
_TEXT = re.compile(r'^ {2}("(?:[^"\\]|\\.)*"): ("(?:[^"\\]|\\.)*"),$')
_PATTERN = re.compile(r'^ {2}\[/(.+)/, ("(?:[^"\\]|\\.)*")\],$')
_PLACE = re.compile(r"\{(\d+)\}")
_OF_MODEL = "mode_probability_"
# A template with fewer letters of its own (`{1}: {2}`) says nothing by itself: something in it must be known.
_FEWEST_LETTERS = 3
# Message and remedy come as one text; nothing the server says has more parts than this.
_MOST_PARTS = 6


@dataclass(frozen=True)
class _Template:
    whole: re.Pattern[str]
    start: re.Pattern[str]
    words: str
    bare: bool
    chunk: str


@dataclass(frozen=True)
class Words:
    """A language's texts; English ones, which need none, are empty."""

    language: Language = "en"
    keys: Mapping[str, str] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)
    patterns: Sequence[tuple[re.Pattern[str], str]] = ()
    templates: Sequence[_Template] = ()

    def said(self, text: str) -> str:
        """Return what was said in English in this language, or as it is where that is not known."""
        plain = " ".join(text.split())
        if self.language == "en" or not plain:
            return text
        if plain in self.words:
            return self.words[plain]
        for pattern, words in self.patterns:
            if pattern.search(plain):
                return pattern.sub(words, plain, count=1)
        found = self._sentence(plain, _MOST_PARTS)
        return text if found is None else found

    def told(self, key: str, fallback: str) -> str:
        """Return the text of a code; where none is known, that of the fallback."""
        return self.keys[key] if key in self.keys else self.said(fallback)

    def metric(self, name: str) -> str:
        """Return the name of a metric; of a motion model's mean probability with the model's own name."""
        model = name.removeprefix(_OF_MODEL)
        whole = self.keys.get("metric.mode_probability")
        if model != name and whole is not None:
            return whole.replace("{model}", model)
        return self.told(f"metric.{name}", name)

    def listed(self, text: str) -> str:
        """Return a text in this language, known as a whole or part by part between commas."""
        whole = self.said(text)
        return ", ".join(map(self.said, text.split(", "))) if whole == text else whole

    def _sentence(self, text: str, parts: int) -> str | None:
        if parts == 0:
            return None
        fitting = [template for template in self.templates if template.chunk in text]
        for template in fitting:
            found = template.whole.fullmatch(text)
            # A place may have taken the end of one sentence and the beginning of the next: then the parts come first.
            if found and not _swallowed(found) and (words := self._filled(template, found, parts)):
                return words
        for template in fitting:
            found = None if template.bare else template.start.match(text)
            rest = found and self._sentence(text[found.end() :], parts - 1)
            if found and rest and (words := self._filled(template, found, parts)):
                return f"{words} {rest}"
        return None

    def _filled(self, template: _Template, found: re.Match[str], parts: int) -> str | None:
        known = [self._sentence(value, parts - 1) for value in found.groups()]
        if template.bare and all(value is None for value in known):
            return None
        said = [
            new or re.sub(r" and (\d+) more$", r" и ещё \1", old)
            for new, old in zip(known, found.groups(), strict=True)
        ]
        return _PLACE.sub(lambda place: said[int(place[1]) - 1], template.words)


def _swallowed(found: re.Match[str]) -> bool:
    return any(re.search(r"[.!?] [A-Z]", re.sub(r"'[^']*'|`[^`]*`", "", value)) for value in found.groups())


@cache
def words_of(language: Language) -> Words:
    """Read the texts of a language once."""
    if language == "en":
        return Words()
    keys: dict[str, str] = {}
    words: dict[str, str] = {}
    sentences: dict[str, str] = {}
    patterns: list[tuple[re.Pattern[str], str]] = []
    places = {"codes": keys, "words": words, "sentences": sentences}
    for path in sorted((page_folder() / "i18n").glob(f"{language}*.js")):
        # Texts of the page itself have keys; the other files without names hold whole sentences.
        place = keys if path.stem == language or path.stem.endswith("-page") else sentences
        for line in path.read_text("utf-8").splitlines():
            if section := _SECTION.match(line):
                place = places.get(section[1] or "", place)
            elif found := _TEXT.match(line):
                place[json.loads(found[1])] = json.loads(found[2])
            elif found := _PATTERN.match(line):
                patterns.append((re.compile(found[1]), _replacement(json.loads(found[2]))))
    return Words(language, keys, words, patterns, _templates(sentences))


def _replacement(words: str) -> str:
    """A replacement as Python writes it; a backslash of the words stays one."""
    return re.sub(r"\$(\d)", r"\\g<\1>", words.replace("\\", r"\\"))


def _letters(template: str) -> int:
    return len(re.sub(r"[^A-Za-z]", "", _PLACE.sub("", template)))


def _templates(sentences: Mapping[str, str]) -> list[_Template]:
    out = []
    for english, words in sorted(sentences.items(), key=lambda item: -_letters(item[0])):
        # `split` would give the numbers of the places too.
        chunks = re.sub(_PLACE, "\0", english).split("\0")
        source = "(.+?)".join(map(re.escape, chunks))
        out.append(
            _Template(
                whole=re.compile(source),
                start=re.compile(rf"{source} (?=\S)"),
                words=words,
                bare=_letters(english) < _FEWEST_LETTERS,
                chunk=max(chunks, key=len),
            )
        )
    return out
