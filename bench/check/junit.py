"""Results of scenarios as JUnit XML, as CI servers read it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree as Xml

from bench.check.crosswire.settings import OFF
from bench.check.suite import Result

_NOT_IN_XML = re.compile(r"[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Controllers say what they like, colours of a terminal too; a CI server reads no report with such a character."""


def junit_xml(results: Sequence[Result]) -> str:
    """A suite for each scenario, a test case in it for each expectation, check, and fault that touched nothing."""
    suites = Xml.Element("testsuites", name="wheelbench")
    for result in results:
        cases = [(verdict.name, "" if verdict.ok else verdict.text) for verdict in result.verdicts]
        cases += [(f"fault {name}", "touched nothing") for name in result.untouched]
        for outcome in result.checks:
            if outcome.state != OFF:
                cases.append((f"check {outcome.name}", "" if outcome.ok else "; ".join(outcome.lines)))
        if result.error or not cases:
            cases.append(("runs", result.error))
        failed = sum(bool(why) for _, why in cases)
        seconds = f"{result.ticks / 1000:.3f}"  # simulated: how long a machine took is not a fact of the run
        suite = Xml.SubElement(
            suites, "testsuite", name=result.name, tests=str(len(cases)), failures=str(failed), time=seconds
        )
        for name, why in cases:
            case = Xml.SubElement(suite, "testcase", classname=result.path, name=name)
            if why:
                Xml.SubElement(case, "failure", message=why)
    Xml.indent(suites)
    text = _NOT_IN_XML.sub("\ufffd", Xml.tostring(suites, encoding="unicode"))
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'
