"""What many trials come to."""

from __future__ import annotations

from waypointctl.evaluation.paths import Case, RandomPaths
from waypointctl.evaluation.result import CaseResult
from waypointctl.evaluation.rollout import Walks
from waypointctl.evaluation.wilson import wilson_interval


def summary(case: Case | RandomPaths, walks: Walks) -> CaseResult:
    """Return the counts and means of the trials of one case."""
    trials, successes = len(walks.success), int(walks.success.sum())
    legs_reached = int(walks.legs_reached.sum())
    time_s, walked_m = walks.time_s[walks.success], walks.walked_m[walks.success]
    return CaseResult(
        name=case.name,
        waypoints=case.path if isinstance(case, Case) else (),
        trials=trials,
        successes=successes,
        rate=successes / trials,
        wilson95=wilson_interval(successes, trials),
        falls=int(walks.fell.sum()),
        timeouts=int(walks.timed_out.sum()),
        mean_time_s=float(time_s.mean()) if successes else None,
        spl=walks.spl,
        paper=case.paper if isinstance(case, Case) else None,
        orbiting=int(walks.orbiting.sum()),
        stuck=int(walks.stuck.sum()),
        strayed=int(walks.strayed.sum()),
        # A trial that ends on its way to a waypoint had set out on that leg, and on none after it.
        legs=legs_reached + int((walks.legs_reached < walks.legs).sum()),
        legs_reached=legs_reached,
        mean_leg_time_s=float(walks.legs_time_s.sum()) / legs_reached if legs_reached else None,
        mean_speed_mps=float(walked_m.sum() / time_s.sum()) if successes else None,
        course=case if isinstance(case, RandomPaths) else None,
    )
