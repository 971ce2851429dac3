#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Listens to nodes and prints the surfaces that they send. Needs python3-protobuf and the messages compiled for Python:

    protoc --proto_path=proto --python_out=DIR proto/srd.proto

usage: PYTHONPATH=DIR datagrams.py ADDRESS PORT FRAMES   prints node, sequence and coefficients in mm; ends after FRAMES frames

It hears nodes without a key. It acknowledges nothing, so a node sends each frame more than once: a frame counts the first time. `srd listen` is what records.
"""

import socket
import sys

import srd_pb2

KINDS_OF_B_AND_C = {100: "B", 101: "C"}


def crc32c(data):
    """Castagnoli's, reflected, as proto/srd.proto asks for."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def decode(datagram):
    """The message of a node's datagram; None for anything else, or one that was damaged on its way."""
    message, check = datagram[:-5], datagram[-5:]
    if len(check) < 5 or check[0] != 15 << 3 | 5 or int.from_bytes(check[1:], "little") != crc32c(b"N" + message):
        return None
    decoded = srd_pb2.NodeDatagram.FromString(datagram)
    return decoded if decoded.version == 1 else None


def coefficients(frame):
    """Mode and mm of a frame; nothing for a frame without a surface."""
    names = [KINDS_OF_B_AND_C.get(code, f"A{code:02}") for code in frame.model.modes]
    return dict(zip(names, frame.coefficients))


def main(arguments):
    if len(arguments) != 3:
        raise SystemExit(__doc__.strip())
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.bind((arguments[0], int(arguments[1])))
    seen = set()
    while len(seen) < int(arguments[2]):
        message = decode(listener.recv(1200))
        if message is None or message.WhichOneof("content") != "frame":
            continue
        frame = (message.node, message.boot, message.sequence)
        if frame not in seen:
            seen.add(frame)
            surface = " ".join(f"{mode}={mm:.4f}" for mode, mm in coefficients(message.frame).items())
            print(message.node.decode(), message.sequence, surface or f"status {message.frame.status}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
