"""What a log's MJCF must not say: other files, sizes that take all memory, and what MuJoCo would read otherwise."""

from __future__ import annotations

import os
import re
from pathlib import Path

import mujoco
import pytest

from tests.sim.hostile_models import ANT, FILES, LARGE, within
from waypointctl.errors import InputError
from waypointctl.limits import VARIABLE, set_limits
from waypointctl.sim.mjcf_audit import COUNTS, ELEMENTS, audited_mjcf
from waypointctl.sim.robots import compile_mjb, load_robot

KNOWN = Path(__file__).with_name("mjcf_attributes.txt")


def refused(source: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        audited_mjcf(source, "model.xml")
    with pytest.raises(InputError):
        compile_mjb(source, "model.xml")


def test_what_is_written_anew_compiles_to_the_same_model() -> None:
    assert compile_mjb(ANT.encode(), "model.xml") == load_robot("ant").to_mjb()
    richer = within(
        "worldbody",
        '<frame pos="0 0 1"><site name="a &quot;b&quot; &lt;&#10;"/><camera name="c" resolution="64 48"/></frame>',
    )
    richer = richer.replace(b"</mujoco>", b'<sensor><rangefinder site="a &quot;b&quot; &lt;&#10;"/></sensor></mujoco>')
    expected = mujoco.MjModel.from_xml_string(richer.decode())
    assert compile_mjb(richer, "model.xml") == mjb(expected)


def mjb(model: mujoco.MjModel) -> bytes:
    import numpy as np

    buffer = np.zeros(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("there", ["file", "pipe", "nothing"])
def test_a_model_that_names_a_file_is_refused_whether_it_is_there_or_not(tmp_path: Path, name: str, there: str) -> None:
    path = tmp_path / "other.xml"
    if there == "file":
        path.write_text("<mujoco/>")
    elif there == "pipe":
        os.mkfifo(path)
    source = FILES[name].replace(b"FILE", str(path).encode())
    refused(source, "is not read: a log's model is made of|a log's model names no other file")


@pytest.mark.parametrize("name", LARGE)
def test_a_model_of_giant_size_is_refused_before_it_is_made(name: str) -> None:
    refused(LARGE[name], "expected|more than|is not read|at most|are read|simulation of its own|not a finite number")


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (b"", "is not XML: no element found"),
        (b"MuJoCo", "is not XML: syntax error"),
        (b"<mujoco>\xff</mujoco>", "is not UTF-8 text: byte 8"),
        (ANT.encode("utf-16"), "is not UTF-8 text"),
        (ANT.encode() + b"\0<include file='x'/>", "is not XML"),
        (ANT.encode() + b"<mujoco/>", "is not XML: junk after document element"),
        (
            b'<robot name="r"><link name="l"/></robot>',
            "model.xml:1: is a URDF: its root is <robot>, that of MJCF is <mu",
        ),
        (b'<?xml version="1.0"?>\n<sdf/>', "model.xml:2: is not MJCF: its root is <sdf>"),
        (
            b'<!DOCTYPE m [<!ENTITY a "b">]><mujoco model="&a;"/>',
            "a document type, which can define entities, is not read",
        ),
        (b'<!DOCTYPE m SYSTEM "file:///etc/passwd"><mujoco/>', "a document type"),
        (b"<mujoco>&a;</mujoco>", "is not XML: undefined entity"),
        (b'<mujoco model="a" model="b"/>', "is not XML: duplicate attribute"),
        (ANT.replace("<option", "<Option").encode(), r"model\.xml:\d+: <Option> is not read"),
    ],
)
def test_what_is_no_mjcf_is_refused_with_its_place(source: bytes, message: str) -> None:
    refused(source, message)


def test_another_encoding_that_is_only_declared_changes_nothing() -> None:
    declared = b'<?xml version="1.0" encoding="utf-16"?>' + ANT.encode()
    assert compile_mjb(declared, "model.xml") == load_robot("ant").to_mjb()


def test_the_limit_on_elements_can_be_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "")
    with pytest.raises(InputError, match=r"more than 2,000 elements\n") as caught:
        audited_mjcf(LARGE["elements"], "model.xml")
    set_limits(re.findall(r"--limit (\S+)", str(caught.value)))
    audited_mjcf(LARGE["elements"], "model.xml")


def schema() -> dict[str, list[str]]:
    """Return the attributes of each element that is read, as the installed MuJoCo has them."""
    found: dict[str, set[str]] = {}
    name = ""
    for line in mujoco.mj_printSchema(False, False).splitlines():
        head = re.match(r" *(\S+) \([!?*R]\)", line)
        name = head[1] if head else name
        words = (line[head.end() :] if head else line).split()
        for each in ("worldbody", "body") if name == "(world)body" else (name,):
            found.setdefault(each, set()).update(words)
    return {name: sorted(attributes) for name, attributes in found.items() if name in ELEMENTS}


def test_every_attribute_of_the_installed_mujoco_was_looked_at() -> None:
    """A new one may name a file or a size: look at it, say so in COUNTS, and only then write it into the list."""
    listed = "".join(f"{name}: {' '.join(attributes)}\n" for name, attributes in sorted(schema().items()))
    assert listed == KNOWN.read_text()
    assert {name for attributes in schema().values() for name in attributes} >= COUNTS.keys()
