#!/usr/bin/env python3
"""Measures anogate-mqtt beside a gateway and a mosquitto: tests/mqtt/figures.py BUILD-FOLDER
Prints a table with the goals; exit status 1 if one is missed. tools/bench mqtt runs it. Only the interface lo is used."""
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
GATEWAY, PROGRAM = (f"{build}/src/{name}" for name in ("anogated", "anogate-mqtt"))
failed = False


def frame(source, message, data):
    body = bytes([0xAB, source, 0xFE, message]) + struct.pack("<H", len(data)) + data
    total = add = 0
    for byte in body:
        total = (total + byte) & 0xFF
        add = (add + total) & 0xFF
    return body + bytes([total, add])


def euler(number):
    return frame(5, 0x03, struct.pack("<hhhB", number % 18000, 0, 0, 1))


def report(what, goal, value, unit):
    global failed
    missed = value > goal
    failed |= missed
    print(f"| {what} | ≤ {goal:g} {unit} | {value:.3g} {unit} |{' **missed**' if missed else ''}", flush=True)


def cpu_seconds(pid):
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_mb(pid):
    with open(f"/proc/{pid}/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def wait_for(process, words):
    for line in process.stderr:
        if words in line:
            return
    sys.exit(f"it ended without '{words}'")


def send_for(device, to, rate, seconds):
    """Sends frames at a rate, and returns how many."""
    begin, sent = time.monotonic(), 0
    while (now := time.monotonic() - begin) < seconds:
        while sent < now * rate:
            sent += 1
            device.sendto(euler(sent), to)
        time.sleep(0.002)
    return sent


class Reader:
    """Live records at a subscriber, with the time from the gateway to it in ms."""

    def __init__(self, port):
        self.process = subprocess.Popen(["mosquitto_sub", "-p", str(port), "-q", "1", "-t", "anogate/v1/+/up/#", "-F", "%U %p"],
                                        stdout=subprocess.PIPE)
        time.sleep(0.5)

    def p99(self):
        self.process.terminate()
        late = []
        for line in self.process.stdout.read().decode().splitlines():
            arrived, record = line.split(" ", 1)
            late.append((float(arrived) - json.loads(record)["time"]) * 1000)
        late.sort()
        return late[int(len(late) * 0.99)] if late else 0


def start_broker(folder):
    broker = subprocess.Popen(["mosquitto", "-c", f"{folder}/m.conf"], stderr=subprocess.DEVNULL)
    time.sleep(0.5)
    return broker


def measure_drain(folder, broker, port, device, gateway, program):
    """How late live records are while a backlog is published, compared with usual. Returns the new broker."""
    reader = Reader(port)
    send_for(device, gateway, 100, 10)
    usual = reader.p99()
    broker.kill()
    broker.wait()
    send_for(device, gateway, 4000, 15)
    broker = start_broker(folder)
    reader = Reader(port)
    wait_for(program, "connected to the broker")
    send_for(device, gateway, 100, 5)
    report("p99 of live records during a drain, compared with usual", 2, reader.p99() / max(usual, 0.1), "×")
    return broker


def main():
    folder = tempfile.mkdtemp()
    control, broker_port, gateway_port = f"{folder}/control.sock", free_port(), free_port()
    device = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    device.bind(("127.0.0.1", 0))
    with open(f"{folder}/m.conf", "w") as file:
        file.write(f"user root\nlistener {broker_port} 127.0.0.1\nallow_anonymous true\n")
    broker = start_broker(folder)
    link = f"udp:127.0.0.1:{device.getsockname()[1]},bind=127.0.0.1:{gateway_port},name=fc"
    gateway = subprocess.Popen([GATEWAY, link, "--control", control, "--log-level", "warn"])
    with open(f"{folder}/mqtt.json", "w") as file:
        json.dump({"broker": f"127.0.0.1:{broker_port}", "name": "g", "control": control, "spool": f"{folder}/spool",
                   "messages": [{"message": "*", "rate": 0}]}, file)
    time.sleep(1)
    program = subprocess.Popen([PROGRAM, "--config", f"{folder}/mqtt.json"], stderr=subprocess.PIPE, text=True)
    wait_for(program, "connected to the broker")
    time.sleep(1)
    try:
        print("| figure | goal | measured |\n|---|---|---|")
        for rate, seconds in ((500, 10), (20, 10)):
            before = cpu_seconds(program.pid)
            sent = send_for(device, ("127.0.0.1", gateway_port), rate, seconds)
            used = cpu_seconds(program.pid) - before
            if rate == 500:
                report("processor time for a message at 500/s", 40, used / sent * 1e6, "µs")
            else:
                report("part of a core at 20/s", 1, used / seconds * 100, "%")
        report("memory", 15, resident_mb(program.pid), "MB")
        broker = measure_drain(folder, broker, broker_port, device, ("127.0.0.1", gateway_port), program)
        report("memory after an outage", 15, resident_mb(program.pid), "MB")
    finally:
        for process in (program, gateway, broker):
            process.send_signal(signal.SIGTERM)
            process.wait(10)
        lines = program.stderr.read().splitlines()
        print("\n" + (lines[-1] if lines else ""))
    sys.exit(1 if failed else 0)


main()
