"""A rule for a robot that gets no closer, which asks for more than the robot can walk."""

from __future__ import annotations

from collections.abc import Iterator

from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.walker import SETTING_OUT_S
from waypointctl.mission.mission import Mission


def stuck_findings(mission: Mission, speed_mps: float) -> Iterator[Finding]:
    """Yield a rule by which a robot that walks as it does counts as stuck."""
    stuck, path = mission.onboard.stuck, ("onboard", "stuck")
    if stuck is None or mission.autonomy == "joint":
        return
    needed_s = stuck.within_m / speed_mps
    asked = f"{stuck.within_m:g} m in {stuck.for_s:g} s"
    if needed_s > stuck.for_s:
        text = (
            f"{asked} is {stuck.within_m / stuck.for_s:.1f} m/s, and the robot walks at {speed_mps:.2f} m/s: it counts "
            f"as stuck on every leg; give it more than {needed_s + SETTING_OUT_S:.1f} s"
        )
        yield Finding("stuck", path, text, consequence="")
    elif SETTING_OUT_S + needed_s > stuck.for_s:
        text = (
            f"{asked}: a robot that stands takes {SETTING_OUT_S:g} s to set out and {needed_s:.2f} s for the way, and "
            f"counts as stuck where it starts; give it more than {needed_s + SETTING_OUT_S:.1f} s"
        )
        yield Finding("stuck", path, text, consequence="")
