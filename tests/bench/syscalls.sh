#!/bin/sh
# System calls of anogated for one frame forwarded from UDP to UDP under load, counted by strace.
#   tests/bench/syscalls.sh ANOGATED [FRAMES]      FRAMES: 200000
# Tracing slows the daemon down, so what is forwarded is read from its status; what the kernel dropped meanwhile is shown.
set -eu
anogated=${1:?the program anogated}
frames=${2:-200000}
for tool in strace curl python3; do
    command -v "$tool" >/dev/null || { echo "syscalls.sh: $tool is missing" >&2; exit 2; }
done
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
socket=$dir/control

strace -f -c -o "$dir/count" "$anogated" --control "$socket" --log-level error \
    udp-listen:127.0.0.1:0,name=air udp-listen:127.0.0.1:0,name=ground &
strace=$!
python3 - "$socket" "$frames" <<'PYTHON'
import json, socket, subprocess, sys, time

control, frames = sys.argv[1], int(sys.argv[2])

def status():
    answer = subprocess.run(["curl", "-s", "--unix-socket", control, "http://anogate/status"], capture_output=True).stdout
    return {link["name"]: link for link in json.loads(answer)["links"]} if answer else None

def frame(source, destination, function, data):
    body = bytes([0xAB, source, destination, function, len(data), 0]) + data
    sum_ = add = 0
    for byte in body:
        sum_ = (sum_ + byte) & 255
        add = (add + sum_) & 255
    return body + bytes([sum_, add])

for _ in range(500):
    links = status()
    if links: break
    time.sleep(0.02)
else:
    sys.exit("syscalls.sh: the daemon does not answer")

host = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
host.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
host.sendto(frame(0xFE, 0xDC, 0xE0, bytes(3)), ("127.0.0.1", links["ground"]["port"]))
host.setblocking(False)
air = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
datagram, to = frame(0xDC, 0xFE, 0x01, bytes(13)), ("127.0.0.1", links["air"]["port"])
for n in range(frames):
    air.sendto(datagram, to)
    if n % 64 == 0:
        try:
            while True: host.recv(2048)
        except BlockingIOError:
            pass
before = -1
while True:
    links = status()
    if links["air"]["frames_in"] == before and links["ground"]["waiting"] == 0: break
    before = links["air"]["frames_in"]
    time.sleep(0.2)
print("frames forwarded:", links["ground"]["frames_out"], " not read in time:", links["air"]["kernel_drops"])
with open(control + ".frames", "w") as f: f.write(str(links["ground"]["frames_out"]))
PYTHON
# strace passes the signal on to nobody: the daemon is its child.
kill -TERM "$(cat "/proc/$strace/task/$strace/children")"
wait "$strace" || true
head -12 "$dir/count"
awk -v frames="$(cat "$socket.frames")" '$NF == "total" { printf "system calls a frame: %.3f\n", $(NF == 5 ? 3 : 4) / frames }' "$dir/count"
