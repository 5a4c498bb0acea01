"""What ``pytest --progress FOLDER`` adds: how far the tests are, and an end to those that hang.

The folder keeps the duration of each test, from which the next run estimates its time.
``scripts/test.sh --slowest`` lists the longest of them: run as a program, this file does it.
"""

import faulthandler
import json
import os
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from patience import patience

HANG = 300.0  # [s] between two signs of life; the longest test takes a fifth of it
EVERY = 20.0  # [s] between two lines


class Watchdog:
    """Ends a process that hangs (one rank waits for another), with its stacks on stderr.

    There is no limit for all tests together: as long as one after the other ends, all is well. The
    limit for each follows the load of the machine, as it is when the test begins. It is a thread of
    C that keeps it, since MPI and PETSc wait without letting Python run.
    """

    def __init__(self, config):
        self.is_worker = hasattr(config, "workerinput")
        # workers of pytest-xdist are to end first: their test fails, the others go on
        spread = hasattr(config.option, "numprocesses") and config.option.numprocesses
        self.seconds = HANG if self.is_worker or not spread else 2.0 * HANG
        self.stderr = os.dup(2)  # the true one, while pytest catches what the tests write
        if not self.is_worker:  # workers wait for each other between tests
            self.arm()

    def arm(self):
        """Count from zero."""
        limit = patience(self.seconds)
        faulthandler.dump_traceback_later(limit, exit=True, file=self.stderr)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self):
        self.arm()
        result = yield
        if self.is_worker:
            faulthandler.cancel_dump_traceback_later()
        return result

    def pytest_runtest_logreport(self):
        self.arm()


class Progress:
    """Lines that say how many tests are done and how long the others will take.

    Failures are also written to ``failed.txt``, which goes when pytest itself has shown them.
    """

    def __init__(self, folder, terminal):
        self.terminal = terminal
        terminal.showfspath = False  # and no line for each file
        self.durations, self.failed = folder / "durations.json", folder / "failed.txt"
        self.start = self.last = time.monotonic()
        self.times, self.to_do, self.failures, self.tests = {}, {}, 0, 0
        folder.mkdir(parents=True, exist_ok=True)
        self.failed.write_text("")
        self.earlier = {}
        if self.durations.exists():
            self.earlier = json.loads(self.durations.read_text())

    def pytest_collection_finish(self, session):
        if session.items:  # none where workers collect
            self.begin([item.nodeid for item in session.items])

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, ids):
        self.begin(ids)

    def begin(self, tests):
        """Expect each test to take as long as the last time, and a new one as long as the mean."""
        if self.tests:  # another worker has found the same
            return
        known = [self.earlier[name] for name in tests if name in self.earlier]
        usual = sum(known) / len(known) if sum(known) > 0.0 else 1.0
        self.to_do = {name: self.earlier.get(name, usual) for name in tests}
        self.tests, self.all = len(tests), sum(self.to_do.values())

    @pytest.hookimpl(wrapper=True)
    def pytest_report_teststatus(self):
        """No letter for each test."""
        category, _, word = yield
        return category, "", word

    def pytest_runtest_logreport(self, report):
        name = report.nodeid
        self.times[name] = self.times.get(name, 0.0) + report.duration
        if report.outcome == "failed":
            self.failures += 1
            self.terminal.write_line(f"FAILED {name}", red=True)
            with self.failed.open("a") as file:
                file.write(f"\nFAILED {name}\n{report.longreprtext}\n")
        if report.when == "teardown":
            self.to_do.pop(name, None)
            self.say()

    def say(self):
        """How far we are, every so often."""
        now = time.monotonic()
        if now - self.last < EVERY:
            return
        self.last, left = now, sum(self.to_do.values())
        elapsed = now - self.start
        done = 1.0 - left / self.all
        to_go = f", about {clock(elapsed / done - elapsed)} to go" if done > 0.02 else ""
        self.terminal.write_line(
            f"{100 * (self.tests - len(self.to_do)) // self.tests:3d} % of {self.tests} tests, "
            f"{self.failures} failed, {clock(elapsed)} so far{to_go}"
        )

    def pytest_sessionfinish(self):
        self.durations.write_text(json.dumps(self.earlier | self.times, indent=0))

    def pytest_unconfigure(self):
        self.failed.unlink()


def clock(seconds):
    """Minutes and seconds."""
    return "{}:{:02d} min".format(*divmod(round(seconds), 60))


def list_slowest(number=30):
    """Print the longest tests of the last run on each number of ranks, and the longest files."""
    for file in sorted(Path("build").glob("tests_*/durations.json")):
        tests = Counter(json.loads(file.read_text()))
        files = Counter()
        for name, seconds in tests.items():
            files[name.partition("::")[0]] += seconds
        print(f"{file.parent}: {clock(tests.total())} of {len(tests)} tests")
        for seconds in (tests, files):
            print(*(f"{t:8.1f} s  {name}" for name, t in seconds.most_common(number)), sep="\n")


if __name__ == "__main__":
    list_slowest(*map(int, sys.argv[1:2]))
