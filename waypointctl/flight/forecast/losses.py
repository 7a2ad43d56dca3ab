"""What may go wrong on a link that loses everything, at once or in the end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.forecast.finding import Finding
from waypointctl.mission.link import Bursts, Link, Loss

_WAYS: Final = ("up", "down")
_FOLLOWS: Final = {
    ("up",): "every message up is lost: no command ever arrives",
    ("down",): "every message down is lost: nothing is ever heard of the robot",
    _WAYS: "every message is lost, both ways: no command ever arrives, and nothing is ever heard of the robot",
}


def loss_findings(link: Link) -> Iterator[Finding]:
    """Yield what of a link loses every message."""
    losses = {way: getattr(link, way).loss for way in _WAYS}
    if dead := tuple(way for way in _WAYS if loses_all(losses[way])):
        yield Finding("loss", ("link", dead[0], "loss"), _FOLLOWS[dead])
    if fading := [way for way in _WAYS if _stays_bad(losses[way])]:
        after = 1 / losses[fading[0]].p
        when = "after the first message" if after == 1 else f"after some {after:.3g} messages, on average,"
        text = f"the link {' and '.join(fading)} never recovers (r is 0): {when} every one is lost"
        yield Finding("loss", ("link", fading[0], "loss"), text)


def loses_all(loss: Loss) -> bool:
    """Tell whether every message is lost, from the first on."""
    if isinstance(loss, Bursts):  # the link begins good
        return loss.one_minus_k == 1 and (loss.p == 0 or loss.one_minus_h == 1)
    return loss == 1


def _stays_bad(loss: Loss) -> bool:
    """Tell whether a link that is good at first loses everything once it is bad."""
    if not isinstance(loss, Bursts) or loses_all(loss):
        return False
    return loss.p > 0 and loss.r == 0 and loss.one_minus_h == 1
