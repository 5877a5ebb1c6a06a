#!/usr/bin/env python3
"""Measures anogate-ros2 beside a gateway, with subscribers of CycloneDDS: tests/ros2/figures.py BUILD-FOLDER
Prints a table with the goals; exit status 1 if one is missed. tools/bench ros2 runs it. Only the interface lo is used."""
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

build = sys.argv[1]
GATEWAY, BRIDGE, LISTENER = (f"{build}/{path}" for path in ("src/anogated", "src/anogate-ros2", "tests/ros2/ros2_listener"))
DOMAIN = "87"
ON_LO = ('<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General></Domain>'
         "</CycloneDDS>")
failed = False


def frame(source, message, data):
    body = bytes([0xAB, source, 0xFE, message]) + struct.pack("<H", len(data)) + data
    total = add = 0
    for byte in body:
        total = (total + byte) & 0xFF
        add = (add + total) & 0xFF
    return body + bytes([total, add])


def inertial(number, source=5):
    return frame(source, 0x01, struct.pack("<hhhhhhB", number % 30000, 0, 0, 0, 0, 0, 0))


def report(what, goal, value, unit):
    global failed
    missed = value > goal
    failed |= missed
    print(f"| {what} | ≤ {goal:g} {unit} | {value:.3g} {unit} |{' **missed**' if missed else ''}", flush=True)


class Listener:
    def __init__(self, *topics):
        self.since = time.monotonic()
        self.process = subprocess.Popen([LISTENER, DOMAIN, *topics], stdout=subprocess.PIPE, env={**os.environ, "CYCLONEDDS_URI": ON_LO})
        os.set_blocking(self.process.stdout.fileno(), False)
        self.rest = b""
        self.lines = []

    def read(self):
        data = self.process.stdout.read()
        if data:
            *lines, self.rest = (self.rest + data).split(b"\n")
            self.lines += [line for line in lines if line.startswith(b"/")]
        return len(self.lines)

    def end(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


class Line:
    """A gateway with one UDP link, the bridge, and a sender."""

    def __init__(self, folder, config):
        self.folder = folder
        self.device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.device.bind(("127.0.0.1", 0))
        self.control = f"{folder}/control.sock"
        self.config = f"{folder}/ros2.json"
        with open(self.config, "w", encoding="utf-8") as file:
            json.dump(config, file)
        own = self.device.getsockname()[1]
        probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        probe.bind(("127.0.0.1", 0))
        self.port = probe.getsockname()[1]
        probe.close()
        self.gateway = subprocess.Popen([GATEWAY, f"udp:127.0.0.1:{own},bind=127.0.0.1:{self.port},name=fc", "--control", self.control,
                                         "--log-level", "error"])
        while not os.path.exists(self.control):
            time.sleep(0.01)
        self.bridge = None

    def start_bridge(self):
        self.since = time.monotonic()
        self.bridge = subprocess.Popen([BRIDGE, "--control", self.control, "--config", self.config, "--domain", DOMAIN, "--interface", "lo"],
                                       stderr=subprocess.DEVNULL)

    def send(self, data):
        self.device.sendto(data, ("127.0.0.1", self.port))

    def send_until(self, listener, count, limit=30):
        """Sends at 100 Hz until the listener has so many messages; returns the monotonic time of that."""
        end = time.monotonic() + limit
        number = 0
        while listener.read() < count:
            if time.monotonic() > end:
                sys.exit(f"no data within {limit} s")
            self.send(inertial(number))
            number += 1
            time.sleep(0.01)
        return time.monotonic()

    def cpu(self):
        with open(f"/proc/{self.bridge.pid}/stat", encoding="ascii") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def resident(self):
        with open(f"/proc/{self.bridge.pid}/status", encoding="ascii") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1000

    def end(self):
        for process in (self.bridge, self.gateway):
            process.send_signal(signal.SIGTERM)
            process.wait()


def starts(line):
    """A subscriber that starts second, then a bridge that is killed and started again, then a bridge that starts second."""
    listener = Listener("/fc/imu/data=Imu")
    report("data at a subscriber that starts second", 1.5, line.send_until(listener, 1) - listener.since, "s")
    worst = 0
    for _ in range(3):
        line.bridge.kill()
        line.bridge.wait()
        before = listener.read()
        line.start_bridge()
        worst = max(worst, line.send_until(listener, before + 1) - line.since)
    report("data after the bridge is killed and started again, worst of 3", 0.2, worst, "s")
    listener.end()
    line.bridge.kill()
    line.bridge.wait()
    listener = Listener("/fc/imu/data=Imu")
    time.sleep(2)
    line.start_bridge()
    report("data at a subscriber after the bridge starts second", 1.5, line.send_until(listener, 1) - line.since, "s")
    listener.end()


def rate(line, stopped):
    """1,000 messages per second for 5 s; with a second subscriber that is stopped."""
    listener = Listener("/fc/imu/data=Imu")
    others = [Listener("/fc/imu/data=Imu")] if stopped else []
    line.send_until(listener, 10)
    for other in others:
        line.send_until(other, 10)
        other.process.send_signal(signal.SIGSTOP)
    begun, cpu, sent = listener.read(), line.cpu(), {}
    time.sleep(0.2)
    begun = listener.read()
    next_at = time.monotonic()
    count = 5000
    for number in range(count):
        sent[number] = time.time_ns()
        line.send(inertial(number))
        next_at += 0.001
        if number % 20 == 0:
            listener.read()    # its pipe must not fill
        time.sleep(max(0, next_at - time.monotonic()))
    end = time.monotonic() + 5
    while listener.read() < begun + count and time.monotonic() < end:
        time.sleep(0.05)
    used = line.cpu() - cpu
    delays = []
    for text in listener.lines[begun:]:
        _, received, _, values = text.split(b" ", 3)
        number = round(json.loads(values)[28] * 100)    # linear_acceleration.x, in cm/s²
        delays.append((int(received) - sent.get(number, int(received))) / 1e6)
    for other in others:
        other.process.send_signal(signal.SIGCONT)
        other.end()
    listener.end()
    delays.sort()
    if not delays:
        sys.exit("no messages arrived")
    return delays, used / count * 1e6


def many(folder):
    """20 devices with 20 topics each, all received by one subscriber."""
    devices = [{"address": address, "prefix": f"d{address}"} for address in range(21, 41)]
    line = Line(folder, {"devices": devices})
    line.start_bridge()
    listener = Listener("/d40/imu/data=Imu")
    messages = [(0x01, 13), (0x02, 9), (0x04, 9), (0x07, 6), (0x08, 12), (0x0D, 4), (0x30, 23), (0x32, 12), (0x05, 13)]
    end = time.monotonic() + 30
    while listener.read() < 10 and time.monotonic() < end:
        for address in range(21, 41):
            for message, size in messages:
                data = bytearray(size)
                if message == 0x30:
                    data[0] = 3
                if message == 0x04:
                    data[0:2] = b"\x10\x27"
                line.send(frame(address, message, bytes(data)))
        time.sleep(0.1)
    report("resident memory, 20 devices with 20 topics", 45, line.resident(), "MB")
    listener.end()
    line.end()


print("| measured | goal | anogate-ros2 |\n|---|---:|---:|")
with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
    line = Line(one, {"raw": False})
    line.start_bridge()
    starts(line)
    delays, cpu = rate(line, False)
    report("latency from a UDP sender through gateway and bridge to a subscriber, 1,000/s, 99th percentile", 5, delays[len(delays) * 99 // 100], "ms")
    report("… median", 5, delays[len(delays) // 2], "ms")
    report("CPU time of the bridge for a message", 60, cpu, "µs")
    delays, _ = rate(line, True)
    report("… 99th percentile, beside a stopped subscriber", 10, delays[len(delays) * 99 // 100], "ms")
    line.end()
    many(two)
sys.exit(failed)
