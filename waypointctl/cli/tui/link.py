"""How a link is put in a line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from waypointctl.units import RATE_UNITS_BPS

if TYPE_CHECKING:
    from waypointctl.mission.link import Link, LinkDirection


def link_text(link: Link) -> str:
    """Return what a link does to messages, in a few words."""
    name = f"link {link.preset}:" if link.preset else "link"
    up, down = _way_text(link.up), _way_text(link.down)
    if up != down:
        return f"{name} {up} up, {down} down"
    return f"{name} without delay" if up == "0 s" else f"{name} {up} each way"


def _way_text(way: LinkDirection) -> str:
    return " with ".join(filter(None, (_delay_text(way), " and ".join(_besides(way)))))


def _delay_text(way: LinkDirection) -> str:
    if way.delay_table is not None:
        delays_s = [row.delay_s for row in way.delay_table]
        text = f"{min(delays_s):g} to {max(delays_s):g} s"
    elif way.contact_plan is not None and not way.has_own_delay:
        text = f"the delays and contacts of {way.contact_plan.file}"
    else:
        text = f"{way.delay_s:g} s"
    if way.jitter_file is not None:
        return f"{text} + {way.jitter_file}"
    normal = " (normal)" if way.jitter_distribution == "normal" else ""
    return f"{text} +- {way.jitter_s:g} s{normal}" if way.jitter_s else text


def _besides(way: LinkDirection) -> Iterator[str]:
    """Yield what a way does besides delaying."""
    loss = way.loss if isinstance(way.loss, float) else way.loss.share
    if loss:
        yield f"{100 * loss:.3g} % lost{'' if isinstance(way.loss, float) else ' in bursts'}"
    if way.duplicate:
        yield f"{100 * way.duplicate:.3g} % duplicated"
    if not way.keep_order:
        yield "reordering"
    if way.rate_bps is not None:
        yield rate_text(way.rate_bps)
    if way.windows is not None:
        every = "" if way.windows_period_s is None else f" every {way.windows_period_s:g} s"
        yield f"{len(way.windows)} window{'s' if len(way.windows) > 1 else ''}{every}"
    if way.contact_plan is not None and way.has_own_delay:
        yield f"the contacts of {way.contact_plan.file}"


def rate_text(rate_bps: float) -> str:
    """Return a rate [bit/s] in the largest unit of which it has one: 9.6 kbit/s."""
    unit, size = max((pair for pair in RATE_UNITS_BPS.items() if pair[1] <= max(rate_bps, 1.0)), key=lambda it: it[1])
    return f"{rate_bps / size:.6g} {unit}"
