from __future__ import annotations

import codecs
import contextlib
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML

from waypointctl.mission.yaml_tree import MAX_BYTES, MAX_DEPTH, NOWHERE, Mark, YamlFault, plain, read_tree


def test_every_value_and_key_has_its_place() -> None:
    tree = read_tree(b"name: x\npoints:\n  - [1, 2.5]\n  - {y: null}\n")
    assert tree.data == {"name": "x", "points": [[1, 2.5], {"y": None}]}
    assert tree.values[("name",)] == Mark(1, 7)
    assert tree.keys[("points",)] == Mark(2, 1)
    assert tree.values[("points", 0, 1)] == Mark(3, 9)
    assert tree.keys[("points", 1, "y")] == Mark(4, 6)


def test_columns_count_characters_and_not_bytes() -> None:
    tree = read_tree("{ä: 1, b: 2}".encode())
    assert tree.values[("b",)] == Mark(1, 11)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12),
        ("-0", 0),
        ("+7", 7),
        ("0o17", 15),
        ("0x1F", 31),
        ("007", 7),
        ("1.", 1.0),
        (".5", 0.5),
        ("1e3", 1000.0),
        ("-1.5E-3", -0.0015),
        ("-.inf", -math.inf),
        ("~", None),
        ("", None),
        ("True", True),
        ("yes", "yes"),
        ("on", "on"),
        ("1_000", "1_000"),
        ("12:30", "12:30"),
        ("2020-01-01", "2020-01-01"),
        ("7 m", "7 m"),
        ("e3", "e3"),
        (".", "."),
    ],
)
def test_plain_scalars_mean_what_the_core_schema_says(text: str, value: object) -> None:
    found = plain(text)
    assert found == value
    assert type(found) is type(value)


def test_a_number_that_is_not_one() -> None:
    found = plain(".nan")
    assert isinstance(found, float)
    assert math.isnan(found)


@pytest.mark.parametrize("digits", ["9" * 10_000, "0x" + "f" * 10_000])
def test_a_number_beyond_all_floats_is_infinite(digits: str) -> None:
    assert plain(digits) == math.inf


def test_quotes_make_text() -> None:
    assert read_tree(b"{a: '12', b: \"true\", c: ''}").data == {"a": "12", "b": "true", "c": ""}


def test_a_byte_order_mark_is_no_content() -> None:
    assert read_tree(b"\xef\xbb\xbfa: 1").data == {"a": 1}


@pytest.mark.parametrize(
    ("line", "column", "source"), [(1, 1, b"\xff"), (1, 5, b"a: \xc3\xa9\xff"), (2, 3, b"\xc3\xa9: 1\nb:\xff")]
)
def test_places_after_a_byte_order_mark_do_not_count_it(line: int, column: int, source: bytes) -> None:
    for text in (source, codecs.BOM_UTF8 + source):
        with pytest.raises(YamlFault, match="is not UTF-8 text: byte 0xff") as caught:
            read_tree(text)
        assert caught.value.mark == Mark(line, column)


def test_a_byte_order_mark_alone_is_empty() -> None:
    with pytest.raises(YamlFault, match="is empty"):
        read_tree(codecs.BOM_UTF8)


def test_a_second_key_is_listed_and_the_first_value_kept() -> None:
    tree = read_tree(b"a: 1\nb: {c: 2, c: {d: 3}}\na: 4\n")
    assert tree.data == {"a": 1, "b": {"c": 2}}
    assert tree.duplicates == [(("b", "c"), Mark(2, 11)), (("a",), Mark(3, 1))]


@pytest.mark.parametrize(
    ("source", "line", "column", "text"),
    [
        (b"", 1, 1, "is empty"),
        (b"# nothing but a comment\n", 1, 1, "is empty"),
        (b"---\n", 1, 1, "is empty"),
        (b"a: [1,", 1, 7, "is not YAML"),
        (b"a: b: c", 1, 5, "mapping values are not allowed here"),
        (b"a: 1\n\tb: 2", 2, 1, "is indented with a tab: YAML needs spaces"),
        (b'a: "\\U00110000"', 1, 5, "is not a character"),
        (b'a: "\\ud800"', 1, 4, "half of a surrogate pair"),
        (b"a: 1\nb: \xff", 2, 4, "is not UTF-8 text: byte 0xff"),
        (b"\xff\xfea\x00", 1, 1, "is not UTF-8 text"),
        (b"a: 1\nb: \x07", 2, 4, "control character #x07"),
        (b"a: &x 1", 1, 4, "the anchor &x is not allowed"),
        (b"a: *x", 1, 4, "the alias *x is not allowed"),
        (b"a: !!python/name:os.system x", 1, 4, "is not allowed: leave it out"),
        (b"a: 1\n---\nb: 1", 2, 1, "a second document"),
        (b"%YAML 1.1\n---\na: 1", 2, 1, "only YAML 1.2"),
        (b"? [a]\n: b", 1, 3, "cannot be a key"),
    ],
)
def test_what_cannot_be_read_says_why_and_where(source: bytes, line: int, column: int, text: str) -> None:
    with pytest.raises(YamlFault) as caught:
        read_tree(source)
    assert caught.value.mark == Mark(line, column)
    assert text in caught.value.text


@pytest.mark.parametrize("opening", [b"[", b"{a: ", b"- "])
def test_nesting_has_a_limit(opening: bytes) -> None:
    with pytest.raises(YamlFault, match=f"nested more than {MAX_DEPTH} levels deep"):
        read_tree(opening * 5_000)


def test_size_has_a_limit() -> None:
    with pytest.raises(YamlFault, match=f"{MAX_BYTES} are allowed"):
        read_tree(b"#" * (MAX_BYTES + 1))


def test_a_thousand_laughs_are_refused_at_the_first() -> None:
    laughs = [b"a0: &a0 [lol, lol]"] + [b"a%d: &a%d [*a%d, *a%d]" % (i, i, i - 1, i - 1) for i in range(1, 40)]
    with pytest.raises(YamlFault, match="anchor &a0") as caught:
        read_tree(b"\n".join(laughs))
    assert caught.value.mark == Mark(1, 5)


# JSON writes what is beyond these as two escapes, which YAML does not take for one character.
_text = st.text(st.characters(max_codepoint=0xD7FF), max_size=8)
_json = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**12), 10**12)
    | st.floats(allow_nan=False, allow_infinity=False)
    | _text,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(_text, inner, max_size=4),
    max_leaves=12,
)


@given(_json.filter(lambda value: value is not None))
def test_reads_json_as_json(value: object) -> None:
    assert read_tree(json.dumps(value).encode()).data == value


@given(st.text(alphabet="ab:-[]{},#&*!|>'\"%@`? \n\t0.é\\x~<", max_size=40))
def test_any_text_is_read_or_refused_as_ruamel_does(text: str) -> None:
    try:
        found = read_tree(text.encode())
    except YamlFault:
        return
    nodes = YAML(typ="safe", pure=True).compose(text)
    assert (nodes.start_mark.line + 1, nodes.start_mark.column + 1) == (found.values[()].line, found.values[()].column)


@given(st.binary(max_size=60))
def test_any_bytes_are_read_or_refused(source: bytes) -> None:
    for text in (source, codecs.BOM_UTF8 + source):
        with contextlib.suppress(YamlFault):
            read_tree(text)


@pytest.mark.parametrize("source", [b"a:\n\t- 1\n", b"a:\n  b: 1\n\tc: 2\n"])
def test_a_tab_that_indents_is_named(source: bytes) -> None:
    with pytest.raises(YamlFault, match="is indented with a tab: YAML needs spaces") as caught:
        read_tree(source)
    assert caught.value.mark is not None
    assert source.decode().splitlines()[caught.value.mark.line - 1][caught.value.mark.column - 1] == "\t"


@pytest.mark.parametrize(
    ("text", "escape", "column"),
    [
        (r'a: "\UFFFFFFFF"', r"\UFFFFFFFF", 5),  # beyond a C int
        (r'a: "\U7FFFFFFF"', r"\U7FFFFFFF", 5),
        (r'a: "x \U00110000"', r"\U00110000", 7),
        (r'"\U80000000": 1', r"\U80000000", 2),
        (r'[ok, "\U0010FFFF\Ufffffffe"]', r"\Ufffffffe", 17),
    ],
)
def test_an_escape_beyond_the_last_character_is_told_where_it_stands(text: str, escape: str, column: int) -> None:
    with pytest.raises(YamlFault) as caught:
        read_tree(f"b:\n{text}".encode() if text.startswith("[") else f"b: 1\n{text}".encode())
    assert caught.value.text == rf"{escape} is not a character: the last one is \U0010FFFF"
    assert caught.value.mark == Mark(2, column)


PIECES = st.sampled_from(
    [
        *"abc:,-?[]{}#&*!|>'\"%@`\\ \n\t\x85",
        *("\\U", "\\u", "\\x", "FFFFFFFF", "D800", "%YAML ", "%TAG ", "---", "...", "!<", "1e9"),
    ]
)


@given(st.lists(PIECES, max_size=30).map("".join))
def test_any_text_is_data_or_one_fault_with_its_place(text: str) -> None:
    places: list[Mark] = []
    try:
        places += read_tree(text.encode()).values.values()
    except YamlFault as fault:
        places.append(fault.mark)
    assert places
    assert NOWHERE not in places
