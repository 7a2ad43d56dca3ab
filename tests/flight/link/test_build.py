"""A mission's link, as it is flown."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from waypointctl.errors import MissionError
from waypointctl.flight.link.build import contacts_of, direction
from waypointctl.flight.link.direction import NO_CONTACT, NOISE, QUEUE_FULL, Delivery, Direction
from waypointctl.mission.link import Link, LinkDirection
from waypointctl.seeding import stream

S = 10**9
PLAN = b"""\
# forth and back at rates of their own, and a light time that grows
a contact +10 +20 1 2 1000
a contact +15 +20 2 1 125
a contact +30 +40 1 2 1000
a range +0 +35 1 2 1
a range +35 +100 1 2 2
"""


def way(**content: Any) -> LinkDirection:
    return Link.model_validate({"up": content}).up


def made(
    given: LinkDirection, files: dict[str, bytes] | None = None, seed: int = 1, name: str = "link.up"
) -> Direction[int]:
    return direction(given, files or {}, seed, name)


def send(link: Direction[int], now_ns: int, size: int = 1) -> Delivery:
    return link.send(now_ns, size, lambda when: when)


def delays(link: Direction[int], count: int) -> list[int]:
    return [send(link, number * S).arrivals_ns[0] - number * S for number in range(count)]


def test_a_way_that_says_nothing_does_nothing() -> None:
    link = made(way())
    assert [send(link, at, 10**9) for at in (0, 5)] == [Delivery(0, 0, (0,), ""), Delivery(5, 5, (5,), "")]
    assert link.state()["random"] == {}, "nothing is drawn"


def test_a_uniform_jitter_is_drawn_as_it_always_was() -> None:
    """Logged flights depend on it: one whole number for each message, from the stream that has the way's own name."""
    link, rng = made(way(delay="1.28 s", jitter="50 ms"), seed=4), stream(4, "link.up")
    last, expected = 0, []
    for number in range(600):
        last = max(last, number * 10**7 + 1_280_000_000 + int(rng.integers(-50_000_000, 50_000_000, endpoint=True)))
        expected.append(last)
    assert [send(link, number * 10**7).arrivals_ns[0] for number in range(600)] == expected


def test_the_ways_and_their_models_draw_from_streams_of_their_own() -> None:
    given = way(delay="1 s", jitter="100 ms", jitter_distribution="normal")
    up, down = delays(made(given), 50), delays(made(given, name="link.down"), 50)
    assert up != down
    assert up == delays(made(given), 50) != delays(made(given, seed=2), 50)
    more = way(delay="1 s", jitter="100 ms", jitter_distribution="normal", loss=0.3, duplicate=0.3)
    deliveries = [send(made_once, number * S) for made_once in [made(more)] for number in range(50)]
    kept = [
        (delivery.arrivals_ns, number) for number, delivery in enumerate(deliveries) if len(delivery.arrivals_ns) == 1
    ]
    assert len(kept) > 20
    assert all(when[0] - number * S == up[number] for when, number in kept), "its delay is none of loss's business"


def test_a_normal_jitter_has_the_deviation_that_is_asked_for() -> None:
    link = made(way(delay="1 s", jitter="10 ms", jitter_distribution="normal", keep_order=False))
    assert np.std(delays(link, 2000)) == pytest.approx(10_000_000, rel=5 / np.sqrt(2 * 2000))


def test_jitter_from_a_file_and_no_message_before_it_was_sent() -> None:
    link = made(way(delay="20 ms", jitter_file="j.txt"), {"j.txt": b"# measured\n0.01\n-0.5\n+1e-3 # late\n"})
    assert set(delays(link, 200)) == {30_000_000, 0, 21_000_000}


def test_a_broken_jitter_file_is_refused() -> None:
    with pytest.raises(MissionError):
        made(way(jitter_file="j.txt"), {"j.txt": b"0.1\nsoon\n"})


def test_a_table_of_delays() -> None:
    rows = [{"at": "10 s", "delay": "1 s"}, {"at": "20 s", "delay": "3 s"}]
    link = made(way(delay_table=rows))
    assert [send(link, at * S).arrivals_ns[0] for at in (0, 10, 15, 30)] == [1 * S, 11 * S, 17 * S, 33 * S]


def test_rate_queue_and_windows() -> None:
    windows = [{"from": "1 s", "to": "2 s"}]
    link = made(way(rate="8 kbit/s", queue="1000 B", windows=windows, windows_period="10 s"))
    assert send(link, 0, 1001).lost == NO_CONTACT, "longer than a window"
    assert send(link, 0, 800) == Delivery(S, 1_800_000_000, (1_800_000_000,), "")
    assert send(link, 0, 201).lost == QUEUE_FULL
    assert send(link, S, 300).departs_ns == 11 * S


def test_loss_in_bursts_and_doubling() -> None:
    link = made(way(loss={"p": 1, "r": 1}))
    assert [send(link, 0).lost for _ in range(4)] == ["", NOISE, "", NOISE]
    assert len(send(made(way(duplicate="100 %")), 0).arrivals_ns) == 2
    assert [bool(send(made(way(loss="30 %"), seed=seed), 0).lost) for seed in range(300)].count(True) == pytest.approx(
        90, abs=40
    )


def test_a_contact_plan_gives_each_way_its_windows_rates_and_light_time() -> None:
    link = Link.model_validate({"contact_plan": {"file": "plan", "from_node": 1, "to_node": 2}})
    up, down = (made(each, {"plan": PLAN}) for each in (link.up, link.down))
    assert send(up, 0, 500) == Delivery(10 * S, 10_500_000_000, (11_500_000_000,), "")
    assert send(up, 34 * S, 2000) == Delivery(34 * S, 36 * S, (38 * S,), "")
    assert send(up, 39 * S, 1001).lost == NO_CONTACT
    assert send(down, 0, 125) == Delivery(15 * S, 16 * S, (17 * S,), "")
    assert contacts_of(link.down, {"plan": PLAN}).next_open_ns(0) == 15 * S


def test_a_delay_beside_a_contact_plan_takes_the_place_of_its_ranges() -> None:
    plan = {"file": "plan", "from_node": 1, "to_node": 2}
    no_ranges = b"\n".join(line for line in PLAN.splitlines() if b"range" not in line)
    link = made(way(contact_plan=plan, delay="250 ms"), {"plan": no_ranges})
    assert send(link, 10 * S, 1000).arrivals_ns == (11_250_000_000,)


def test_a_broken_contact_plan_is_refused() -> None:
    plan = {"file": "plan", "from_node": 1, "to_node": 2}
    with pytest.raises(MissionError):
        made(way(contact_plan=plan, delay="1 s"), {"plan": b"a contact soon +20 1 2 1000\n"})


def test_a_duplicate_draws_its_jitter_from_a_stream_of_its_own() -> None:
    link, rng = (
        made(way(delay="1 s", jitter="50 ms", duplicate=1, keep_order=False), seed=4),
        stream(4, "link.up.second"),
    )
    for number in range(1, 20):
        second_ns = int(rng.integers(-50_000_000, 50_000_000, endpoint=True))
        assert (number + 1) * S + second_ns in send(link, number * S).arrivals_ns


def test_a_file_that_was_not_read_with_the_mission_is_missed() -> None:
    with pytest.raises(MissionError, match=r"j\.txt: the mission refers to it, and it was not read with it"):
        made(way(jitter_file="j.txt"))
