"""Missions drawn at random, with something of everything that a file can say."""

from __future__ import annotations

from hypothesis import strategies as st

from waypointctl.mission.fields import Start
from waypointctl.mission.link import Link, LinkDirection
from waypointctl.mission.mission import Defaults, Expect, Mission, Waypoint
from waypointctl.mission.onboard import Area, Corner, Geofence, LinkLoss, Onboard, OnFailure, Stuck
from waypointctl.mission.operator import ScheduledCommand, TelemetryRate


def number(low: float, high: float) -> st.SearchStrategy[float]:
    """Draw a finite number within bounds."""
    return st.floats(low, high, allow_nan=False)


_tiny = 5e-324
line = st.text(st.characters(exclude_categories=("C", "Z")), min_size=1, max_size=20)
position = st.tuples(number(-1e4, 1e4), number(-1e4, 1e4))
_leg = {
    "acceptance": st.sampled_from(["box", "radius"]),
    "tolerance_m": number(_tiny, 100),
    "timeout_s": number(_tiny, 86400),
    "hold_s": number(0, 86400),
}
_waypoint = st.builds(Waypoint, position_m=position, **{key: st.none() | value for key, value in _leg.items()})
_way = st.tuples(number(0, 864000), number(0, 1)).map(
    lambda pair: LinkDirection(delay_s=pair[0], jitter_s=pair[0] * pair[1])
)
_circle = st.builds(Area, center_m=position, radius_m=number(0.1, 100))
_triangle = st.just(Area(name="yard", corners=tuple(Corner(position_m=at) for at in ((0, 0), (9, 0), (0, 9)))))
_areas = st.lists(_circle | _triangle, max_size=3).map(tuple)
_fence = st.builds(Geofence, keep_in=_areas, keep_in_match=st.sampled_from(["any", "all"]), keep_out=_areas)
_onboard = st.builds(
    Onboard,
    on_failure=st.none() | st.builds(OnFailure, retry=st.integers(0, 9)),
    stuck=st.none() | st.just(Stuck()),
    link_loss=st.none() | st.builds(LinkLoss, after_s=number(1, 100)),
    geofence=_fence,
)
_schedule = st.lists(
    st.builds(ScheduledCommand, at_s=number(0, 1000), do=st.sampled_from(["hold", "resume", "skip", "abort"])),
    max_size=3,
)


@st.composite
def missions(draw: st.DrawFn) -> Mission:
    """Draw a mission."""
    waypoints = draw(st.lists(_waypoint, min_size=1, max_size=5))
    names = draw(st.lists(line.filter(lambda name: not name.startswith("WP")), max_size=len(waypoints), unique=True))
    named = [w.model_copy(update={"name": name}) for w, name in zip(waypoints, names, strict=False)]
    return Mission(
        name=draw(st.from_regex(r"[A-Za-z0-9][A-Za-z0-9._ -]{0,20}[A-Za-z0-9]", fullmatch=True)),
        description=draw(st.text(max_size=60)),
        seed=draw(st.integers(0, 2**63 - 1)),
        policy=draw(line),
        start=draw(st.builds(Start, position_m=position, heading_deg=number(-360, 360))),
        autonomy=draw(st.sampled_from(["mission", "waypoint", "short_range_goal", "joint"])),
        schedule=tuple(draw(_schedule)),
        defaults=draw(st.builds(Defaults, **_leg)),
        waypoints=(*named, *waypoints[len(named) :]),
        link=Link(up=draw(_way), down=draw(_way)),
        telemetry=TelemetryRate(rate_hz=draw(number(0.001, 50))),
        onboard=draw(_onboard),
        expect=Expect(
            reached=draw(st.just("all") | st.integers(0, len(waypoints))),
            max_time_s=draw(st.none() | number(_tiny, 1e6)),
        ),
    )
