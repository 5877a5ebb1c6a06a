#!/usr/bin/env python3
"""Reads a parameter, sets it, and shows the attitude live: attitude.py SOCKET NAME VALUE [COUNT]"""
import http.client, itertools, json, os, socket, sys, urllib.parse
if len(sys.argv) not in (4, 5) or not sys.argv[-1].isdigit() and len(sys.argv) == 5: sys.exit(__doc__)
path, name, value = sys.argv[1], urllib.parse.quote(sys.argv[2]), sys.argv[3]
limit = int(sys.argv[4]) if len(sys.argv) > 4 else None    # ends after so many; without it, with Ctrl-C

class Gateway(http.client.HTTPConnection):
    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.connect(path)

def ask(method, target, body=None):
    gateway = Gateway("anogate")
    gateway.request(method, target, body and json.dumps(body), {"Content-Type": "application/json"})
    answer = gateway.getresponse()
    return answer if answer.status == 200 else sys.exit(json.load(answer)["error"])

try:
    devices = json.load(ask("GET", "/devices"))["devices"] or sys.exit("no devices found")
    device = devices[0]["address"]
    print(name, "was", json.load(ask("GET", f"/devices/{device}/parameters/{name}"))["value"])
    print(name, "is", json.load(ask("PUT", f"/devices/{device}/parameters/{name}", {"value": value}))["stored"])
    try: import matplotlib.pyplot as plot
    except ImportError: plot = None    # the numbers are enough
    i, frames = -1, map(json.loads, ask("GET", f"/frames?id=euler&from={device}&direction=in&elsewhere=no&limit.euler=10"))
    for i, frame in enumerate(itertools.islice((f["fields"] for f in frames if "fields" in f), limit)):
        print("rol {rol:7.2f}  pit {pit:7.2f}  yaw {yaw:7.2f}".format(**frame), flush=True)
        if plot and not limit:
            for key, color in ("rol", "r"), ("pit", "g"), ("yaw", "b"): plot.plot(i, frame[key], color + ".")
            plot.pause(0.01)
    if not limit or i + 1 < limit: sys.exit("the gateway ended")
except KeyboardInterrupt: sys.exit("ended by Ctrl-C")
except BrokenPipeError: os._exit(1)    # nobody reads any more
except (OSError, ValueError, http.client.HTTPException) as fault: sys.exit(f"{path}: the gateway is not there: {fault}")
