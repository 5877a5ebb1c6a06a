#!/usr/bin/env python3
"""Reads a parameter, sets it, and shows the attitude live: attitude.py SOCKET NAME VALUE [COUNT]"""
import http.client, itertools, json, socket, sys
path, name, value = sys.argv[1:4]
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

device = json.load(ask("GET", "/devices"))["devices"][0]["address"]
print(name, "was", json.load(ask("GET", f"/devices/{device}/parameters/{name}"))["value"])
print(name, "is", json.load(ask("PUT", f"/devices/{device}/parameters/{name}", {"value": float(value)}))["stored"])
try:
    import matplotlib.pyplot as plot
except ImportError:
    plot = None    # the numbers are enough
frames = map(json.loads, ask("GET", f"/frames?id=euler&from={device}&direction=in&limit.euler=10"))
for i, frame in enumerate(itertools.islice((f["fields"] for f in frames if "fields" in f), limit)):
    print("rol {rol:7.2f}  pit {pit:7.2f}  yaw {yaw:7.2f}".format(**frame), flush=True)
    if plot and not limit:
        for key, color in ("rol", "r"), ("pit", "g"), ("yaw", "b"): plot.plot(i, frame[key], color + ".")
        plot.pause(0.01)
