"""Whether a robot can be balanced from the ground: autonomy `joint` over a round trip."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.traffic import (
    CONTROL_HZ,
    Traffic,
    action_bytes,
    body_bytes,
    mean_rate_bps,
    telemetry_bps,
)
from waypointctl.flight.link.contacts import BITS_PER_BYTE, Contacts, airtime_ns
from waypointctl.mission.mission import Mission
from waypointctl.units import seconds

# From this round trip on nobody balances the ant from the ground: 0 of 20 flights of each route, against 19 and 13 of
# 20 at 0.02 s (docs/delay.md, "joint, by round trip").
FALLS_FROM_RTT_S: Final = 0.04


def joint_findings(mission: Mission, traffic: Traffic) -> Iterator[Finding]:
    """Yield that a robot whose every action comes from the ground will fall."""
    if mission.autonomy == "joint" and control_round_trip_s(traffic) >= FALLS_FROM_RTT_S:
        text = (
            f"autonomy joint over a round trip of {control_round_trip_s(traffic):.3g} s: every flight of the delay "
            f"study fell from {FALLS_FROM_RTT_S:g} s on (docs/delay.md); choose autonomy mission, waypoint or heading"
        )
        yield Finding("delay", ("autonomy",), text)


def falls(mission: Mission, traffic: Traffic) -> bool:
    """Return whether a robot falls that is led action by action over a link: states or actions come late, or wait."""
    return control_round_trip_s(traffic) >= FALLS_FROM_RTT_S or any(
        has_bps is not None and needed_bps > has_bps for needed_bps, has_bps in control_rates(mission, traffic).values()
    )


def control_rates(mission: Mission, traffic: Traffic) -> dict[str, tuple[float, float | None]]:
    """Return what goes up and down under autonomy joint and what the link carries [bit/s]; None for any amount."""
    up_bps = action_bytes() * BITS_PER_BYTE * CONTROL_HZ
    down_bps = telemetry_bps(mission) + body_bytes() * BITS_PER_BYTE * CONTROL_HZ
    return {
        "up": (up_bps, mean_rate_bps(traffic.up.contacts)),
        "down": (down_bps, mean_rate_bps(traffic.down.contacts)),
    }


def control_round_trip_s(traffic: Traffic) -> float:
    """Return how old a state is when the action that answers it arrives, at mission start [s]."""
    sizes = ((traffic.up, action_bytes()), (traffic.down, body_bytes()))
    return sum(seconds(way.delay(0) + _airtime_ns(way.contacts, size)) for way, size in sizes)


def _airtime_ns(contacts: Contacts, size: int) -> int:
    """Return how long a message takes to be sent in the first contact [ns]."""
    return airtime_ns(size, contacts.windows[0].rate_bps) if contacts.windows else 0
