"""How long the robot has been on a leg, by its own clock, as far as the ground has heard.

A leg that is led from the ground begins on board with the first of its carrots that is STARTED there: the
acknowledgement says when. How much of its time is over is read from the time stamp of the newest message from the
robot. So a round trip costs the leg nothing before it begins, and nothing at its end. What the robot stands in between,
waiting for the next carrot, is the robot's time and counts.

Where nothing is told, the ground's own clock has to do: a leg is given up when the answer to a command that had left
as late as its time-out would have been here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from waypointctl.log.messages import Ack, Stage, Telemetry
from waypointctl.ops.ground.order import Order

_NOT_BEGUN = frozenset({Stage.RECEIVED, Stage.ACCEPTED, Stage.REJECTED, Stage.SKIPPED})


@dataclass(slots=True)
class LegClock:
    """The clock of the leg under way.

    Attributes:
        answer_by: by when a command that leaves at a time [ns] is answered; None for never.
        leaves_ns: when a command that is sent at a time [ns] leaves; None for never.
        began_ns: when the leg began, on the robot's clock; None while that has not been heard of.
    """

    answer_by: Callable[[int], int | None]
    leaves_ns: Callable[[int], int | None] = lambda sent_ns: sent_ns
    began_ns: int | None = None
    _sent_ns: int = 0  # when the leg's first carrot is sent
    _told_ns: int = -1  # the robot's clock, by the newest message of it
    _unsent: list[Order] = field(default_factory=list)  # carrots of this leg, which are still thought about
    _carrots: set[int] = field(default_factory=set)  # those sent, until one of them has begun the leg

    def restart(self, sent_ns: int) -> None:
        """Wait for another leg to begin, or for the same one anew; its first carrot is sent at a time [ns]."""
        self.began_ns, self._sent_ns = None, sent_ns
        self._unsent.clear()
        self._carrots.clear()

    def of_this_leg(self, carrot: Order) -> Order:
        """Take note that an order which is to be sent belongs to this leg, and return it."""
        if self.began_ns is None:
            self._unsent.append(carrot)
        return carrot

    def issued(self, command_id: int, order: Order) -> None:
        """Learn the id of an order that has been sent, of this leg or not."""
        places = [place for place, carrot in enumerate(self._unsent) if carrot is order]
        if places:
            del self._unsent[: places[0] + 1]  # what was to be sent before it has been dropped
            self._carrots.add(command_id)

    def hear(self, message: Ack | Telemetry) -> None:
        """Take what has arrived."""
        self._told_ns = max(self._told_ns, message.issued_ns)
        told = message.commands if isinstance(message, Telemetry) else (message,)
        if not any(each.command_id in self._carrots and each.stage not in _NOT_BEGUN for each in told):
            return
        self.began_ns = message.issued_ns
        self._unsent.clear()
        self._carrots.clear()

    def is_over(self, timeout_ns: int) -> bool:
        """Tell whether the robot is known to have spent more than this on the leg [ns]."""
        return self.began_ns is not None and self._told_ns - self.began_ns > timeout_ns

    def is_silent(self, now_ns: int, timeout_ns: int) -> bool:
        """Tell whether the end of this time [ns] should have been heard of by now, whatever became of the leg."""
        begins_ns = self.leaves_ns(self._sent_ns) if self.began_ns is None else self.began_ns
        over_ns = (self._sent_ns if begins_ns is None else begins_ns) + timeout_ns
        left_ns = self.leaves_ns(over_ns)
        heard_ns = None if left_ns is None else self.answer_by(left_ns)
        return now_ns > (over_ns if heard_ns is None else heard_ns)
