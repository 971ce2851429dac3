# SPDX-License-Identifier: Apache-2.0
"""A bad network between nodes and a host: loses, doubles, delays and reorders their datagrams, in both directions, or lets
nothing through at all.

usage: fault_proxy.py LISTEN:PORT HOST:PORT [LOSS [DUPLICATES [DELAY_MS [SEED]]]]

Every node gets a socket of its own towards the host, so that the host tells them apart. Each datagram is lost with
probability LOSS, doubled with DUPLICATES, and comes after 0 to DELAY_MS: later ones overtake it. Says "ready" when it
listens; "away" and "back" on stdin close and open the way; ends with stdin and says how many it passed and lost.
"""

import heapq
import itertools
import random
import selectors
import socket
import sys
import time

CHUNK = 2048  # more than a datagram


def parsed(text):
    host, port = text.rsplit(":", 1)
    return host, int(port)


class Proxy:
    def __init__(self, listen, host, loss=0.0, duplicates=0.0, delay_ms=0.0, seed=1):
        self.host, self.loss, self.duplicates, self.delay = host, float(loss), float(duplicates), float(delay_ms) / 1000
        self.random = random.Random(int(seed))
        self.away = self.ended = False
        self.passed = self.lost = 0
        self.due, self.order = [], itertools.count()
        self.outer = {}  # by node's address: the socket towards the host
        self.inner = self.open(None)
        self.inner.bind(listen)

    def open(self, node):
        one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        one.setblocking(False)
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            one.setsockopt(socket.SOL_SOCKET, option, 4 << 20)
        if node is not None:
            one.bind(("", 0))
            self.selector.register(one, selectors.EVENT_READ, node)
        else:
            self.selector = selectors.DefaultSelector()
            self.selector.register(one, selectors.EVENT_READ, None)
        return one

    def put(self, datagram, send_from, to):
        for _ in range(2 if self.random.random() < self.duplicates else 1):
            if self.away or self.random.random() < self.loss:
                self.lost += 1
            else:
                heapq.heappush(self.due, (time.monotonic() + self.delay * self.random.random(), next(self.order), datagram,
                                          send_from, to))

    def take(self, one, node):
        while True:
            try:
                datagram, sender = one.recvfrom(CHUNK)
            except OSError:  # nothing more, or nobody listens there
                return
            if node is not None:
                self.put(datagram, self.inner, node)
                continue
            if sender not in self.outer:
                self.outer[sender] = self.open(sender)
            self.put(datagram, self.outer[sender], self.host)

    def listen_to(self, stdin):
        line = stdin.readline()
        self.ended = not line
        if line:
            self.away = line.strip() == "away"

    def run(self, stdin):
        self.selector.register(stdin, selectors.EVENT_READ, stdin)
        print("ready", flush=True)
        while not self.ended:
            wait = max(0, self.due[0][0] - time.monotonic()) if self.due else None
            for key, _ in self.selector.select(wait):
                if key.fileobj is stdin:
                    self.listen_to(stdin)
                else:
                    self.take(key.fileobj, key.data)
            while self.due and self.due[0][0] <= time.monotonic():
                _, _, datagram, send_from, to = heapq.heappop(self.due)
                try:
                    send_from.sendto(datagram, to)
                    self.passed += 1
                except OSError:
                    self.lost += 1
        print(f"passed {self.passed}, lost {self.lost}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        raise SystemExit(__doc__.strip())
    Proxy(parsed(sys.argv[1]), parsed(sys.argv[2]), *sys.argv[3:]).run(sys.stdin)
