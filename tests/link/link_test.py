# SPDX-License-Identifier: Apache-2.0
"""Nodes and host as processes, each in a network namespace of its own, and between them a proxy that loses, doubles and
reorders datagrams. Frames are made up, everything that sends, receives and records is the product's own.

Needs root (network namespaces); says so and skips otherwise. SRD_LINK_SECONDS: how long the frames of each case go on.
"""

import collections
import csv
import os
import pathlib
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
SRD, NODE = os.environ["SRD_PROGRAM"], os.environ["SRD_LINK_NODE"]
SECONDS = float(os.environ.get("SRD_LINK_SECONDS", 15))
KILLS = int(os.environ.get("SRD_LINK_KILLS", 20))
HZ = 200


def namespaces_work():
    if os.geteuid() != 0 or shutil.which("ip") is None:
        return False
    name = f"srd-probe-{os.getpid()}"
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True, check=False).returncode == 0
    if made:
        subprocess.run(["ip", "netns", "del", name], check=True)
    return made


class Network:
    """A bridge of its own with one namespace a name, 10.99.0.1 and on."""

    def __init__(self, *names):
        self.tag = f"srd{os.getpid() % 100000}"
        self.names = ["lan", *names]
        for name in self.names:
            self.ip("netns", "add", self.of(name))
        self.ip("-n", self.of("lan"), "link", "add", "bridge", "type", "bridge")
        self.ip("-n", self.of("lan"), "link", "set", "bridge", "up")
        for number, name in enumerate(names, 1):
            port = f"port{number}"
            self.ip("-n", self.of("lan"), "link", "add", port, "type", "veth", "peer", "name", "eth0", "netns", self.of(name))
            self.ip("-n", self.of("lan"), "link", "set", port, "master", "bridge", "up")
            self.ip("-n", self.of(name), "address", "add", f"10.99.0.{number}/24", "dev", "eth0")
            for device in ("eth0", "lo"):
                self.ip("-n", self.of(name), "link", "set", device, "up")

    def of(self, name):
        return f"{self.tag}-{name}"

    def address(self, name):
        return f"10.99.0.{self.names.index(name)}"

    @staticmethod
    def ip(*words):
        subprocess.run(["ip", *words], check=True, capture_output=True)

    def start(self, name, *command, **more):
        return subprocess.Popen(["ip", "netns", "exec", self.of(name), *map(str, command)], **more)

    def close(self):
        for name in self.names:
            subprocess.run(["ip", "netns", "del", self.of(name)], check=False, capture_output=True)


class Arrivals(threading.Thread):
    """When each row of a record came, by the clock that its frame was timed with."""

    def __init__(self, file):
        super().__init__(daemon=True)
        self.file, self.delays, self.over = file, [], False
        self.start()

    def run(self):
        while not self.file.exists() and not self.over:
            time.sleep(0.01)
        with self.file.open() as rows:
            rest = ""
            while not self.over:
                rest += rows.read()
                *lines, rest = rest.split("\n")
                now = time.clock_gettime_ns(time.CLOCK_MONOTONIC)
                self.delays += [(now - int(line.split(",")[3])) / 1e9 for line in lines if not line.startswith("node,")]
                time.sleep(0.01)

    def end(self):
        self.over = True
        self.join()
        return sorted(self.delays)


@unittest.skipUnless(namespaces_work(), "needs root and network namespaces")
class Link(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.record = self.folder / "run.csv"
        self.running = []
        self.addCleanup(self.end_all)

    def network(self, nodes):
        self.nodes = [f"n{number}" for number in range(1, nodes + 1)]
        self.net = Network("host", "proxy", *self.nodes)
        self.addCleanup(self.net.close)
        subprocess.run([SRD, "keygen", *self.nodes, "--out", self.folder / "keys"], check=True, capture_output=True)

    def end_all(self):
        for process in self.running:
            if process.poll() is None:
                process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe:
                    pipe.close()

    def start(self, name, *command, **more):
        self.running.append(self.net.start(name, *command, **more))
        return self.running[-1]

    def start_host(self, *more):
        there = ("--append",) if self.record.exists() else ()
        return self.start("host", SRD, "listen", "--bind", "10.99.0.1:47810", "--csv", self.record, "--keys",
                          self.folder / "keys", *there, *more, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def start_proxy(self, *faults):
        proxy = self.start("proxy", sys.executable, "-B", HERE / "fault_proxy.py", "10.99.0.2:47810", "10.99.0.1:47810", *faults,
                           stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.assertEqual(proxy.stdout.readline(), "ready\n")
        return proxy

    def start_node(self, name, frames, *more):
        return self.start(name, NODE, name, "10.99.0.2:47810", HZ, frames, "--key", self.folder / f"keys/{name}.key", *more,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    def end_host(self, host):
        host.send_signal(signal.SIGTERM)
        self.assertEqual(host.wait(30), 0)

    def rows(self):
        """Sequences by node and boot, as they stand in the record."""
        found = collections.defaultdict(list)
        with self.record.open(newline="") as file:
            for row in csv.DictReader(file):
                found[row["node"], row["boot"]].append(int(row["sequence"]))
        return found

    def assert_whole(self, processes, frames):
        for process in processes:
            self.assertEqual(process.communicate(timeout=120)[0], f"frames {frames} lost 0 unacknowledged 0\n")
        found = self.rows()
        self.assertEqual(sorted(node for node, _ in found), self.nodes)
        for sequences in found.values():
            self.assertEqual(sequences, list(range(frames)))

    def test_a_bad_link_brings_every_frame_once_within_a_second(self):
        self.network(3)
        host = self.start_host()
        self.start_proxy(0.3, 0.1, 20)
        arrivals = Arrivals(self.record)
        frames = int(SECONDS * HZ)
        nodes = [self.start_node(name, frames) for name in self.nodes]
        for node in nodes:
            node.wait(SECONDS + 60)
        time.sleep(0.2)
        delays = arrivals.end()
        self.end_host(host)
        self.assert_whole(nodes, frames)
        print(f"{len(delays)} frames: median {delays[len(delays) // 2]:.3f} s, 99.9 % within "
              f"{delays[len(delays) * 999 // 1000]:.3f} s, last {delays[-1]:.3f} s")
        self.assertLess(delays[len(delays) * 999 // 1000], 1)

    def test_a_link_that_was_away_for_a_minute_loses_nothing(self):
        self.network(1)
        host = self.start_host()
        proxy = self.start_proxy(0.3, 0.1, 20)
        frames = 70 * HZ
        node = self.start_node("n1", frames)
        time.sleep(3)
        proxy.stdin.write("away\n")
        proxy.stdin.flush()
        time.sleep(60)
        proxy.stdin.write("back\n")
        proxy.stdin.flush()
        node.wait(120)
        self.end_host(host)
        self.assert_whole([node], frames)

    def test_host_and_node_killed_at_random_lose_nothing(self):
        self.network(1)
        self.start_proxy(0.1, 0.1, 5)
        draw = random.Random(3)
        host, spill, count = self.start_host(), self.folder / "spill", self.folder / "count"
        given, kills = [], 0
        while kills < KILLS:
            count.write_bytes(struct.pack("<Q", 0))
            node = self.start_node("n1", 10 ** 9, "--spill", spill, "--count", count)
            time.sleep(draw.uniform(0.1, 1.5))
            if draw.random() < 0.5:
                host.kill()
                host.wait()
                kills += 1
                time.sleep(draw.uniform(0, 0.7))
                host = self.start_host()
                time.sleep(draw.uniform(0, 0.5))
            if kills < KILLS:
                node.kill()
                node.wait()
                kills += 1
            else:
                node.terminate()
                node.wait(60)
            given.append(struct.unpack("<Q", count.read_bytes())[0])
        last = self.start_node("n1", HZ, "--spill", spill)
        last.wait(60)
        given.append(HZ)
        for _ in range(200):
            if not any(spill.iterdir()):
                break
            last = self.start_node("n1", HZ, "--spill", spill)
            last.wait(60)
            given.append(HZ)
        self.end_host(host)
        found = self.rows()
        for sequences in found.values():
            self.assertEqual(sequences, list(range(len(sequences))))
        # What was given within the last milliseconds before a kill had no number yet.
        recorded = sum(map(len, found.values()))
        print(f"{kills} kills, {len(given)} lives, {sum(given)} frames given, {recorded} in the record")
        self.assertLessEqual(recorded, sum(given))
        self.assertGreaterEqual(recorded, sum(given) - 5 * len(given))


if __name__ == "__main__":
    unittest.main(verbosity=1)
