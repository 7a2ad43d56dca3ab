"""Print the README's table of what a round trip costs, flown now."""

from __future__ import annotations

from pathlib import Path

from waypointctl.flight.fly import fly
from waypointctl.mission.files import load_mission
from waypointctl.mission.link import Link, LinkDirection
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import load_policy
from waypointctl.units import seconds

ROOT = Path(__file__).resolve().parent.parent
DELAYS_S = (0.0, 0.4, 1.28, 5.0)


def flight_time_s(mission: Mission, autonomy: str, delay_s: float) -> float:
    """Return how long a mission takes on the operator's clock, in [s]."""
    way = LinkDirection(delay_s=delay_s)
    asked = mission.model_copy(update={"autonomy": autonomy, "link": Link(up=way, down=way)})
    policy = load_policy(ROOT / "policies" / "ant-waypoint")
    return seconds(fly(asked, policy, lambda message: None).sim_time_ns)


def main() -> None:
    """Print the table."""
    mission = load_mission(ROOT / "missions" / "paper-two-point-moon.yaml").mission
    print(f"| one-way delay | {' | '.join(f'{delay_s:g} s' for delay_s in DELAYS_S)} |")
    print(f"|---|{'---|' * len(DELAYS_S)}")
    for autonomy in ("mission", "waypoint"):
        times = (f"{flight_time_s(mission, autonomy, delay_s):.2f} s" for delay_s in DELAYS_S)
        print(f"| `{autonomy}` | {' | '.join(times)} |")


if __name__ == "__main__":
    main()
