"""Text that is shown: nothing in it steers a terminal, hides, reorders or breaks a line."""

from __future__ import annotations

import json
import subprocess
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.display_text import MOST_CHARACTERS, printable, printable_lines, shell_word

# Any code point, halves of surrogate pairs among them, and those that matter often.
TEXTS = st.text(
    st.one_of(
        st.characters(),
        st.integers(0xD800, 0xDFFF).map(chr),
        st.sampled_from(
            "\x00\t\n\r\x1b\x7f\x85\x9b\xad\u061c\u200b\u200d\u2028\u202e\u2066\ufeff\u3164\ufe0f\U000e0001"
        ),
    )
)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\x1b[2Jb", r"a\u001b[2Jb"),
        ("two\nlines\r\tand a tab", r"two\nlines\r\tand a tab"),
        ("\x7f\x9b\x85\xad", r"\u007f\u009b\u0085\u00ad"),
        ("left\u202eright\u2066x\u2069", r"left\u202eright\u2066x\u2069"),
        ("no\u200bwidth\ufeff\u3164\ufe0f", r"no\u200bwidth\ufeff\u3164\ufe0f"),
        ("line\u2028end", r"line\u2028end"),
        ("\udcff of a name that is not UTF-8", r"\udcff of a name that is not UTF-8"),
        ("\U000e0041", r"\udb40\udc41"),
        ("Größe 近い ñ נ 🛰 e\u0301", "Größe 近い ñ נ 🛰 e\u0301"),
        ("", ""),
    ],
)
def test_what_cannot_be_seen_is_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown
    assert printable_lines(text) == shown.replace(r"\n", "\n")


@given(TEXTS)
def test_nothing_hidden_is_left(text: str) -> None:
    shown = printable(text, 1 << 20)
    assert {unicodedata.category(each) for each in shown}.isdisjoint({"Cc", "Cf", "Cs", "Cn", "Co", "Zl", "Zp"})
    assert printable(shown, 1 << 20) == shown
    assert printable_lines(text).split("\n") == [printable(line, 1 << 20) for line in text.split("\n")]


@given(TEXTS)
def test_json_stays_the_same_json(text: str) -> None:
    written = json.dumps({"name": text}, ensure_ascii=False)
    shown = json.loads(printable_lines(written))["name"]
    # Two halves of a surrogate pair become one character, as in any JSON that is ASCII.
    assert shown.encode("utf-16", "surrogatepass") == text.encode("utf-16", "surrogatepass")


def test_a_long_text_keeps_its_beginning_and_its_end() -> None:
    shown = printable("x" * 1_000_000 + ".yaml:3:4")
    assert len(shown) < MOST_CHARACTERS + 40
    assert shown.startswith("xxx")
    assert "...(999,009 characters)..." in shown
    assert shown.endswith("x.yaml:3:4")


@given(TEXTS.filter(lambda text: text and "\x00" not in text))
def test_a_word_for_a_shell_can_be_shown(text: str) -> None:
    assert printable(shell_word(text), 1 << 20) == shell_word(text)


@pytest.mark.parametrize(
    "text", ["plain", "with space", "it's", "a\nb", "\x1b[31m'\\", "Größe", "\udcff", "\u202e\U000e0041"]
)
def test_a_shell_reads_the_word_back(text: str) -> None:
    done = subprocess.run(["bash", "-c", f"printf %s {shell_word(text)}"], capture_output=True, check=True)
    assert done.stdout == text.encode(errors="surrogateescape")
