"""Links that are known by a name. What a mission writes beside the name takes the place of the preset's values.

Sources, and how they become one way's values:

- moon: light time over the Moon's mean distance, 384,400 km / 299,792.458 km/s = 1.282 s. Light time alone.
- moon-relay: what surface operations through a ground network see in practice, 3 to 10 s for the round trip; the
  5 s of the ESA-ESRIC rover field test, half each way.
- mars-near: light time at the closest approach, 54.6 million km: 182 s.
- mars-far: light time at superior conjunction, 401 million km: 1338 s.
- iss: ground control of robots on the station through relay satellites, 6 to 8 s for the round trip: 3.5 s each way,
  0.5 s more or less.
- lan: a robot in the next room: half a millisecond over switched Fast Ethernet (100 Mbit/s, IEEE 802.3u).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Literal, TypeAlias

from waypointctl.units import number_in

PresetName: TypeAlias = Literal["moon", "moon-relay", "mars-near", "mars-far", "iss", "lan"]

# Of each way: none of them is known to be different up and down.
PRESETS: Final[Mapping[str, Mapping[str, Any]]] = {
    "moon": {"delay_s": 1.282},
    "moon-relay": {"delay_s": 2.5},
    "mars-near": {"delay_s": 182.0},
    "mars-far": {"delay_s": 1338.0},
    "iss": {"delay_s": 3.5, "jitter_s": 0.5},
    "lan": {"delay_s": 0.0005, "jitter_s": 0.0002, "rate_bps": 100e6},
}

# Alternative fields: one of them that is given replaces all of the preset's.
_TOGETHER: Final = (
    ("delay_s", "delay_table"),
    ("jitter_s", "jitter_distribution", "jitter_file"),
    ("windows", "windows_period_s"),
)
_OF_A_CONTACT_PLAN: Final = ("delay_s", "delay_table", "rate_bps", "windows", "windows_period_s")


def over_preset(name: str, given: Mapping[str, Any], bare: Mapping[str, str]) -> dict[str, Any]:
    """Return a way's values: a preset's, and in place of them what is given.

    Args:
        name: of the preset.
        given: what the file has for the way, under either name of a field.
        bare: each bare name, and its field.
    """
    written = {bare.get(key, key) for key in given}
    replaced = set(written)
    for fields in _TOGETHER:
        if written & set(fields):
            replaced.update(fields)
    if "contact_plan" in written:
        replaced.update(_OF_A_CONTACT_PLAN)
    return {key: value for key, value in PRESETS[name].items() if key not in replaced} | dict(given)


def how_to_write_link(word: str) -> str:
    """Return how to write a value that was given in place of a link's mapping."""
    import difflib  # 10 ms that a good file need not wait for

    if number_in(word) is not None:
        return f"write 'link: {{delay: {word}}}' for a one-way delay"
    near = [word] if word in PRESETS else [name for name in PRESETS if name.startswith(word)]
    near = near or difflib.get_close_matches(word, PRESETS, n=1, cutoff=0.5)
    if near:
        return "write " + " or ".join(f"'link: {{preset: {name}}}'" for name in near)
    return f"for a preset write 'link: {{preset: {'|'.join(PRESETS)}}}'"
