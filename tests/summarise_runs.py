#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sums ctest's JUnit files: lists what was skipped and why, what failed, and ends with one line of counts.

usage: summarise_runs.py STAGE=junit.xml ... JOB=exit:CODE ...
A stage without a readable file did not get as far as its tests: it counts as one failure. A job counts as one test, passed
with code 0.
"""
import re
import sys
import xml.etree.ElementTree as ElementTree

# ctest marks these as skipped; any other reason for not running a test (no executable) is a failure.
MEANT_TO_SKIP = ("SKIP_REGULAR_EXPRESSION_MATCHED", "SKIP_RETURN_CODE", "Disabled")


def skip_reason(case):
    """What GTEST_SKIP() << ... said: the lines between "file:line: Skipped" and the "[  SKIPPED ]" mark."""
    output = case.findtext("system-out") or ""
    said = re.search(r": Skipped\n(.*?)\n*\[  SKIPPED \]", output, re.DOTALL)
    if said and said.group(1).strip():
        return " ".join(said.group(1).split())
    said = re.search(r"^SKIP(?:PED)?: *(.+)$", output, re.MULTILINE)
    if said:
        return said.group(1).strip()
    mark = case.find("skipped")
    return mark.get("message", "no reason given") if mark is not None else "no reason given"


def verdict(case):
    if case.find("failure") is not None or case.find("error") is not None or case.get("status") == "fail":
        return "failed"
    mark = case.find("skipped")
    if mark is None and case.get("status", "run") == "run":
        return "passed"
    if case.get("status") == "disabled":
        return "skipped"
    message = mark.get("message", "") if mark is not None else ""
    return "skipped" if message.startswith(MEANT_TO_SKIP) else "failed"


def main(arguments):
    counts = {"passed": 0, "failed": 0, "skipped": 0}
    skipped, failed = {}, []
    for argument in arguments:
        stage, _, path = argument.partition("=")
        if path.startswith("exit:"):
            result = "passed" if path == "exit:0" else "failed"
            counts[result] += 1
            if result == "failed":
                failed.append(f"{stage}: ended with code {path[len('exit:'):]} (see its output above)")
            continue
        try:
            cases = ElementTree.parse(path).getroot().findall(".//testcase")
        except (OSError, ElementTree.ParseError):
            cases = []
        if not cases:
            counts["failed"] += 1
            failed.append(f"{stage}: did not configure, build or find a test (see its output above)")
        for case in cases:
            result = verdict(case)
            counts[result] += 1
            if result == "failed":
                failed.append(f"{stage}: {case.get('name')}")
            elif result == "skipped":
                skipped.setdefault((case.get("name"), skip_reason(case)), []).append(stage)
    if skipped:
        print("Skipped:")
        for (name, reason), stages in skipped.items():
            print(f"  {name} ({', '.join(stages)}): {reason}")
    if failed:
        print("Failed:")
        for line in failed:
            print(f"  {line}")
    print(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return 1 if counts["failed"] or not arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
