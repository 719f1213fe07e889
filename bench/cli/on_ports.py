"""A headless run in which a part is real: `wheelbench replay --role`. The loop has a process of its own."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bench.cli.output import say
from bench.errors import spelt

if TYPE_CHECKING:
    from bench.check.run import Run
    from bench.io.process.child import Prepared
    from bench.io.process.link import ProcessLink

STOP_KEYS = frozenset(b" \n\rq\x1b")


def run_on_ports(args: argparse.Namespace, job: Run) -> int:
    """Run a job's inputs against real ports, in real time; print what happened."""
    from bench.cli.headless import asked_to_stop
    from bench.errors import EXIT_FAILED, EXIT_OK, UsageError
    from bench.io.process.link import ProcessLink

    if args.golden is not None:
        raise UsageError("--golden: goes with the role sim; what is real is judged by a scenario's expectations")
    if args.can == "recorded":
        raise UsageError("--can recorded: goes with the role sim; give the address of a bus")
    link = ProcessLink(
        job.bench,
        job.inputs,
        lambda: prepared(args, job),
        ticks=job.ticks,
        watched=False,
        rescue=lambda: stop_motors(args, job),
    )
    tell = _silent if args.json else _say
    for port in link.ports:
        where = f"; the other end opens {port.where}" if port.where else ""
        tell(0, f"{port.name}{where}{f' ({port.note})' if port.note else ''}")
    notices: list[tuple[float, str]] = []

    def told(tick: int, text: str) -> None:
        notices.append((tick / 1000, text))
        tell(tick, text)

    try:
        with asked_to_stop() as asked, _stop_key() as pressed:
            link.wait(lambda: bool(asked) or pressed(), told)
    finally:
        link.close()
    result: Any = link.result
    stopped = link.now_tick < job.ticks
    verdicts, untouched = result["verdicts"], result["untouched"]
    if args.json:
        facts = result["facts"] | {"role": args.role, "lateness": link.lateness, "notices": notices}
        facts["scheduling"] = link.scheduling
        if verdicts:
            facts["expectations"] = [one.as_dict() for one in verdicts]
        print(json.dumps(facts))
    else:
        say(*result["lines"])
        late = link.lateness
        say(
            f"late      p50 {late['p50_us']:.0f}, p99 {late['p99_us']:.0f}, p99.9 {late['p999_us']:.0f},"
            f" at most {late['max_us']:.0f} us; {late['over_1_ms_percent']:.3f} % of the ticks over 1 ms;"
            f" {link.scheduling}"
        )
        if args.record:
            say(f"recorded  {args.record}")
        if stopped:
            say(f"stopped   at {link.now_tick / 1000:.3f} s of {job.ticks / 1000:.1f} s")
        for one in verdicts:
            say(f"{'expect' if one.ok else 'EXPECT':10}{one.text}")
        for name in untouched:
            say(f"FAULT     {name}: touched nothing, so the run proves nothing about it; check its times")
    if stopped:
        raise KeyboardInterrupt
    return EXIT_OK if all(one.ok for one in verdicts) and not untouched else EXIT_FAILED


def driven_link(args: argparse.Namespace, job: Run) -> ProcessLink:
    """For a dashboard: the loop of a job whose inputs a person makes. Says where the ports are, and waits for them."""
    from bench.cli.headless import asked_to_stop
    from bench.io.process.link import ProcessLink

    link = ProcessLink(
        job.bench, job.inputs, lambda: prepared(args, job), operator=True, rescue=lambda: stop_motors(args, job)
    )
    for port in link.ports:
        say(f"{port.name}{f'; the other end opens {port.where}' if port.where else ''}", flush=True)
    with asked_to_stop() as asked:
        while not link.has_begun:
            link.poll()
            for notice in link.take_notices():
                say(notice, flush=True)
            if asked:
                link.close()
                raise KeyboardInterrupt
            wait_a_moment()
    return link


def stop_motors(args: argparse.Namespace, job: Run) -> None:
    """The loop's process died and could not: tell real motors to stop, if their bus can be opened at all."""
    from bench.errors import BenchError
    from bench.io.can_port import open_can
    from bench.io.limiter import Limiter
    from bench.io.rig import OutBus

    if args.role != "motors":
        return
    try:
        port = open_can("--can", args.can)
    except BenchError:
        return  # the run's own failure is about to be told
    OutBus(port).end(Limiter(job.bench.robot).stop)
    port.close()


def wait_a_moment() -> None:
    """A screen's frame."""
    from bench.io.clock import wait_ns

    wait_ns(50_000_000)


def prepared(args: argparse.Namespace, job: Run) -> Prepared:
    """In the loop's own process: ports, recorder, and who follows the run."""
    from bench.check.summary import Summary
    from bench.io.process.child import Prepared
    from bench.io.roles import take_role

    # Late ticks bunch what came evenly; the recording of such a run can be checked afterwards (`wheelbench check`).
    job.checks = None
    job.bench.world.timing = None  # real wires take their own time
    bench, rig = take_role(job.bench, args.role, rc=args.rc, slamware=args.slamware, can=args.can, armed=args.arm)
    job.bench = bench
    job.info = replace(job.info, role=args.role, wires_can_bitrate=None, wires_slamware_baud=None, wires_also=None)
    injector = job.injector
    try:
        recorder = job.recorder(args.record, overwrite=args.overwrite) if args.record else None
    except BaseException:
        rig.close()
        raise
    summary = Summary(len(bench.robot.wheels))

    def witness() -> None:
        if injector is not None:
            touches = injector.take_touches()
            if touches and recorder is not None:
                recorder.witness([touch.text for touch in touches])

    def finish() -> dict[str, object]:
        lines = summary.lines(job)
        lost = f"; ports were lost {rig.losses} times" if rig.losses else ""
        superseded = sum(bus.superseded for bus in rig.buses)
        late = f"; {superseded} late frames gave way to newer ones" if superseded else ""
        limited = f"; {rig.limiter.clamped} frames were limited" if rig.limiter and rig.limiter.clamped else ""
        lines.append(f"role      {args.role}{lost}{late}{limited}")
        return {
            "lines": lines,
            "facts": summary.facts(job) | {"port_losses": rig.losses, "superseded_frames": superseded},
            "verdicts": job.judge.verdicts() if job.judge else [],
            "untouched": injector.untouched() if injector else [],
        }

    takers = [taker for taker in (recorder, summary, job.judge) if taker is not None]
    return Prepared(bench, rig, takers, finish, witness)


def _say(tick: int, text: str) -> None:
    say(f"{tick / 1000:7.3f} s  {text}", flush=True)


def _silent(tick: int, text: str) -> None:
    print(f"{tick / 1000:7.3f} s  {spelt(text)}", file=sys.stderr, flush=True)


@contextmanager
def _stop_key() -> Iterator[Callable[[], bool]]:
    """Whether a key that stops was pressed; never, where stdin is no terminal."""
    import select
    import termios
    import tty

    if not sys.stdin or not sys.stdin.isatty():
        yield lambda: False
        return
    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)

    def pressed() -> bool:
        if not select.select([terminal], [], [], 0)[0]:
            return False
        try:
            # All that was typed since the last look: sys.stdin would keep what stands behind the first key to itself.
            keys = os.read(terminal, 4096)
        except OSError:
            return True  # the terminal has gone
        return not keys or not STOP_KEYS.isdisjoint(keys)

    try:
        tty.setcbreak(terminal)
        say("space stops", flush=True)
        yield pressed
    finally:
        with suppress(termios.error):  # it may have gone
            termios.tcsetattr(terminal, termios.TCSADRAIN, before)
