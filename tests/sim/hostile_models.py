"""MJCF that reads other files, or takes all memory or time: the ant's, with something put into it."""

from __future__ import annotations

from waypointctl.robots.load import load_robot

ANT = load_robot("ant").files["ant.xml"].decode()


def within(section: str, inner: str) -> bytes:
    """Put something into the ant's model; into a section that it has, or one of its own."""
    if f"<{section}>" in ANT:
        return ANT.replace(f"<{section}>", f"<{section}>{inner}", 1).encode()
    return ANT.replace("</mujoco>", f"<{section}>{inner}</{section}></mujoco>").encode()


def with_option(text: str) -> bytes:
    return ANT.replace("<option ", f"<option {text} ").encode()


def at_root(inner: str) -> bytes:
    return ANT.replace("</mujoco>", f"{inner}</mujoco>").encode()


FILES = {
    "include": at_root('<include file="FILE"/>'),
    "Include": at_root('<Include file="FILE"/>'),
    "include in a body": within("worldbody", '<body><include file="FILE"/></body>'),
    "mesh": within("asset", '<mesh name="m" file="FILE"/>'),
    "hfield": within("asset", '<hfield name="h" file="FILE" size="1 1 1 1"/>'),
    "texture": within("asset", '<texture name="t" type="2d" file="FILE"/>'),
    "cube": within("asset", '<texture name="t" type="cube" fileright="FILE"/>'),
    "skin": within("asset", '<skin name="s" file="FILE"/>'),
    "model": within("asset", '<model name="m" file="FILE"/>'),
    "flexcomp": within("worldbody", '<flexcomp name="f" type="mesh" file="FILE"/>'),
    "plugin": at_root('<extension><plugin plugin="FILE"/></extension>'),
    "mesh elsewhere": within("asset", '<mesh name="m" file="../m.stl"/>'),
    "mesh dir": within("asset", '<mesh name="m" file="m.stl"/>').replace(b"<compiler ", b'<compiler meshdir="/tmp" '),
}


LARGE = {
    "hfield": within("asset", '<hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/>'),
    "hfields": within("asset", "".join(f'<hfield name="{n}" nrow="4000" ncol="4000" size="1 1 1 1"/>' for n in "ab")),
    "texture": within("asset", '<texture name="t" type="2d" builtin="flat" width="16000" height="16000"/>'),
    "textures": within(
        "asset", "".join(f'<texture name="{n}" type="cube" builtin="flat" width="1200"/>' for n in "ab")
    ),
    "channels": within("asset", '<texture name="t" type="2d" builtin="flat" width="64" height="64" nchannel="1000"/>'),
    "two numbers": within("asset", '<texture name="t" type="2d" builtin="flat" width="1 99999" height="64"/>'),
    "nuserdata": at_root('<size nuserdata="2000000000"/>'),
    "nkey": at_root('<size nkey="1000000"/>'),
    "nuser_geom": at_root('<size nuser_geom="10000000"/>'),
    "njmax": at_root('<size njmax="10000000"/>'),
    "nconmax": at_root('<size nconmax="10000000"/>'),
    "nstack": at_root('<size nstack="10000000"/>'),
    "memory": at_root('<size memory="8G"/>'),
    "exabytes": at_root('<size memory="1E"/>'),
    "iterations": with_option('iterations="2000000000"'),
    "ls_iterations": with_option('ls_iterations="2000000000"'),
    "noslip_iterations": with_option('noslip_iterations="2000000000"'),
    "ccd_iterations": with_option('ccd_iterations="2000000000"'),
    "sdf_iterations": with_option('sdf_iterations="2000000000"'),
    "in words": with_option('iterations="1e9"'),
    "hexadecimal": with_option('iterations="0x7fffffff"'),
    "empty": with_option('iterations=""'),
    "replicate": within("worldbody", '<replicate count="1000000"><geom size="1"/></replicate>'),
    "composite": within("worldbody", '<body><composite type="cable" count="1000000 1 1"/></body>'),
    "flexcomp": within("worldbody", '<flexcomp name="f" type="grid" count="1000 1000 1000"/>'),
    "mesh": within("asset", '<mesh name="m" builtin="sphere" params="12"/>'),
    "lengthrange": ANT.replace("<compiler ", '<compiler><lengthrange timestep="1e-9"/></compiler><compiler ').encode(),
    "muscle": within("actuator", '<muscle joint="front_left_hip"/>'),
    "general muscle": within("actuator", '<general gaintype="muscle" joint="front_left_hip"/>'),
    "nsample": within("actuator", '<motor nsample="100000000" joint="front_left_hip"/>'),
    "actdim": within("actuator", '<general actdim="100000000" joint="front_left_hip"/>'),
    "user sensor": within("sensor", '<user dim="2000000000"/>'),
    "rays": within("sensor", '<rangefinder camera="c"/>'),
    "shadows": within("visual", '<quality shadowsize="1000000"/>'),
    "slices": within("visual", '<quality numslices="1000000"/>'),
    "picture": within("visual", '<global offwidth="1000000"/>'),
    "elements": within("worldbody", '<geom size="1"/>' * 2001),
    "joints": within("worldbody", "".join('<body pos="0 0 9"><freejoint/><geom size="1"/></body>' for _ in range(128))),
    "depth": within("worldbody", '<body><geom size="1"/>' * 100 + "</body>" * 100),
    "bytes": at_root(f"<!-- {' ' * 2**20} -->"),
    "nan": with_option('density="nan"'),
    "infinity": with_option('gravity="0 0 -Infinity"'),
    "nan step": ANT.replace('timestep="0.01"', 'timestep="NaN(1)"').encode(),
}
