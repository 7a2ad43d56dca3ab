"""What an MJCF must not say: other files, sizes that take all memory, and what MuJoCo would read otherwise."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.robots.folders import ant_of, audited, tetrahedron
from tests.sim.hostile_models import ANT, FILES, LARGE, within
from waypointctl.errors import InputError
from waypointctl.limits import VARIABLE, set_limits
from waypointctl.robots.load import load_robot
from waypointctl.sim.mjcf_allowed import COUNTS, ELEMENTS

KNOWN = Path(__file__).with_name("mjcf_attributes.txt")


def refused(source: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        audited(source)


def test_what_is_written_anew_compiles_to_the_same_model() -> None:
    assert ant_of(ANT.encode()).to_mjb() == load_robot("ant").to_mjb() == mjb(mujoco.MjModel.from_xml_string(ANT))
    richer = within(
        "worldbody",
        '<frame pos="0 0 1"><site name="a &quot;b&quot; &lt;&#10;"/><camera name="c" resolution="64 48"/></frame>',
    )
    richer = richer.replace(b"</mujoco>", b'<sensor><rangefinder site="a &quot;b&quot; &lt;&#10;"/></sensor></mujoco>')
    assert ant_of(richer).to_mjb() == mjb(mujoco.MjModel.from_xml_string(richer.decode()))


def mjb(model: mujoco.MjModel) -> bytes:
    buffer = np.zeros(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


@pytest.mark.parametrize("name", FILES)
def test_a_model_that_names_a_file_outside_its_folder_or_of_another_kind_is_refused(name: str) -> None:
    refused(FILES[name].replace(b"FILE", b"/tmp/other.xml"), r"is not read|not in the robot's folder|which is not")


HULL = '<mujoco><compiler meshdir="{}"/><asset><mesh {}/></asset><worldbody><geom type="mesh" mesh="hull"/></worldbody>'


def test_meshes_are_read_from_the_folder_and_given_to_mujoco_by_other_names() -> None:
    source = HULL.format("meshes", 'file="hull.STL" scale="2 2 2"') + "</mujoco>"
    found = audited(source.encode(), **{"meshes/hull.STL": tetrahedron()})
    assert set(found.files) == {"model.xml", "meshes/hull.STL"}
    assert found.assets == {"0.stl": tetrahedron()}
    model = mujoco.MjModel.from_xml_string(found.xml, dict(found.assets))
    direct = mujoco.MjModel.from_xml_string(
        HULL.format("", 'name="hull" file="b.stl"') + "</mujoco>", {"b.stl": tetrahedron(2.0)}
    )
    np.testing.assert_allclose(model.mesh_vert, direct.mesh_vert, atol=1e-6)


def test_an_included_file_is_read_as_if_it_stood_there() -> None:
    parts = {"parts/motors.xml": b"<mujocoinclude><actuator><motor joint='hip'/></actuator></mujocoinclude>"}
    body = b"<worldbody><body><joint name='hip'/><geom size='1'/></body></worldbody>"
    found = audited(b"<mujoco>" + body + b"<include file='parts/motors.xml'/></mujoco>", **parts)
    assert mujoco.MjModel.from_xml_string(found.xml).nu == 1
    assert set(found.files) == {"model.xml", "parts/motors.xml"}


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (
            "<mujoco>\n<include file='model.xml'/></mujoco>",
            "model.xml:2: <include> file='model.xml': is included already",
        ),
        ("<mujoco><include file='other.xml'/></mujoco>", "other.xml:1: <geom> size='nan': is not a finite number"),
        ("<mujoco><include file='no.xml'/></mujoco>", "no.xml: there is no such file"),
        ("<mujoco><include file='a.xml' prefix='x'/></mujoco>", "<include> has a 'file' and nothing else"),
        (
            HULL.format("", "file='hull.stl'") + "</mujoco>",
            "model.xml:1: names the file 'hull.stl': there is no such file",
        ),
        (HULL.format("..", "file='hull.stl'") + "</mujoco>", "names the file '../hull.stl', which is not in"),
        (HULL.format("", "builtin='sphere' params='12'") + "</mujoco>", "is not read: give the mesh as a file"),
        ("<mujoco><asset><texture file='a.png' type='2d'/></asset></mujoco>", "names a texture that is not a PNG"),
        ("<mujoco><asset><texture file='b.png' type='2d'/></asset></mujoco>", "more than 16,777,216 pixels"),
    ],
)
def test_a_file_that_a_model_cannot_name_is_told_with_its_place(source: str, message: str) -> None:
    png = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR" + (2**20).to_bytes(4) * 2
    others = {"other.xml": b"<mujoco><worldbody><geom size='nan'/></worldbody></mujoco>", "a.png": b"x", "b.png": png}
    with pytest.raises(InputError, match=re.escape(message)):
        audited(source.encode(), **others)


def test_the_files_of_a_robot_have_a_limit_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "robot-files=500")
    with pytest.raises(InputError, match="the limit robot-files is 500 B"):
        audited((HULL.format("", "file='hull.stl'") + "</mujoco>").encode(), **{"hull.stl": tetrahedron() * 3})


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
    assert ant_of(declared).to_mjb() == load_robot("ant").to_mjb()


def test_the_limit_on_elements_can_be_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "")
    with pytest.raises(InputError, match=r"more than 2,000 elements\n") as caught:
        audited(LARGE["elements"])
    set_limits(re.findall(r"--limit (\S+)", str(caught.value)))
    audited(LARGE["elements"])


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
