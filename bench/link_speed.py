"""How fast the link is, and how much memory it holds, against a loop that does nothing but keep the messages in order.

Run: python bench/link_speed.py [--messages 1000000] [--rounds 5] [--json]

Two carry the same messages in turns on one core, and ratios are taken per turn, so that a noisy machine disturbs both
alike:
  link   one direction with all of its models: bursts of loss, normal jitter, a rate, a queue, windows that come again
  peer   an event loop on heapq alone: each message is pushed with a fixed delay and popped when it is due
Times are the process's CPU time. 100 bytes every 2 ms over 1.28 s, in contact for 48 s of each minute: the queue is
full in each gap. What has arrived is fetched every 100 messages, as a control loop does. Memory is the most that Python
held on to beyond what it had before, by tracemalloc, in a run of its own; messages are numbers, and what has arrived is
dropped.
"""

from __future__ import annotations

import argparse
import heapq
import json
import os
import statistics
import tracemalloc
from collections.abc import Callable
from time import process_time

os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # one core

from waypointctl.flight.link.contacts import Contacts, Window  # noqa: E402
from waypointctl.flight.link.direction import Direction  # noqa: E402
from waypointctl.flight.link.impairments import (  # noqa: E402
    GilbertElliott,
    fixed_delay,
    normal_jitter,
)
from waypointctl.seeding import stream  # noqa: E402
from waypointctl.units import NS_PER_S  # noqa: E402

SIZE_BYTES = 100
EVERY_NS = 2_000_000
DELAY_NS = 1_282_000_000
FETCH_EVERY = 100
END_NS = 1 << 61


def whole_link() -> Direction[int]:
    return Direction(
        delay=fixed_delay(DELAY_NS),
        jitter=normal_jitter(20_000_000, stream(0, "jitter")),
        loss=GilbertElliott(0.01, 0.3, 0.5, 0.001, stream(0, "loss")),
        contacts=Contacts([Window(0, 48 * NS_PER_S, 2e6)], 60 * NS_PER_S),
        queue_bytes=1 << 16,
    )


def itself(arrives_ns: int) -> int:
    return arrives_ns


def carry_by_link(messages: int) -> tuple[int, int]:
    """Return how many messages arrived, and how many were lost."""
    link = whole_link()
    arrived = lost = 0
    for number in range(messages):
        now_ns = number * EVERY_NS
        lost += bool(link.send(now_ns, SIZE_BYTES, itself).lost)
        if number % FETCH_EVERY == 0:
            for _ in link.due(now_ns):
                arrived += 1
    return arrived + sum(1 for _ in link.due(END_NS)), lost


def carry_by_peer(messages: int) -> tuple[int, int]:
    """Return the same of a loop without a link model."""
    events: list[tuple[int, int, int]] = []
    arrived = 0
    for number in range(messages):
        now_ns = number * EVERY_NS
        arrives_ns = now_ns + DELAY_NS
        heapq.heappush(events, (arrives_ns, number, itself(arrives_ns)))
        if number % FETCH_EVERY == 0:
            while events and events[0][0] <= now_ns:
                heapq.heappop(events)
                arrived += 1
    return arrived + len(events), 0


def cpu_s(carry: Callable[[int], tuple[int, int]], messages: int) -> float:
    begin = process_time()
    arrived, lost = carry(messages)
    took_s = process_time() - begin
    assert arrived + lost == messages
    return took_s


def peak_bytes(messages: int) -> int:
    tracemalloc.start()
    try:
        carry_by_link(messages)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def measure(messages: int, rounds: int) -> dict[str, float]:
    turns = [(cpu_s(carry_by_link, messages), cpu_s(carry_by_peer, messages)) for _ in range(rounds)]
    ours_s, theirs_s = (statistics.median(times) for times in zip(*turns, strict=True))
    arrived, lost = carry_by_link(messages)
    return {
        "messages": messages,
        "arrived": arrived,
        "lost": lost,
        "messages_per_s": round(messages / ours_s),
        "messages_per_s_best": round(messages / min(ours for ours, _ in turns)),
        "messages_per_s_peer": round(messages / theirs_s),
        "ratio_to_peer": round(statistics.median(ours / theirs for ours, theirs in turns), 2),
        "peak_kib": round(peak_bytes(messages) / 1024),
        "peak_kib_of_a_tenth": round(peak_bytes(messages // 10) / 1024),
    }


def print_table(found: dict[str, float]) -> None:
    print(f"{found['messages']:,} messages over one direction of the link, one core, CPU time")
    print(f"  arrived {found['arrived']:,}, lost {found['lost']:,}")
    print(f"  the link       {found['messages_per_s']:>10,} messages/s (best turn {found['messages_per_s_best']:,})")
    print(f"  heapq alone    {found['messages_per_s_peer']:>10,} messages/s: {found['ratio_to_peer']} times less work")
    peak, of_a_tenth = found["peak_kib"], found["peak_kib_of_a_tenth"]
    print(f"  memory at most {peak:>10,} KiB; with a tenth of the messages {of_a_tenth:,} KiB")


def main() -> None:
    parser = argparse.ArgumentParser(description="The link's speed and memory, against a bare event loop.")
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = measure(options.messages, options.rounds)
    if options.json:
        print(json.dumps(found, indent=2))
    else:
        print_table(found)


if __name__ == "__main__":
    main()
