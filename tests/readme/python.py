# The Python of include/ano/README does what is said there: python.py ANOGATED SOURCE
import http.client, json, pathlib, re, signal, socket, subprocess, sys, tempfile, time

anogated, source = sys.argv[1:]


class Control(http.client.HTTPConnection):
    def __init__(self, path):
        super().__init__("anogate", timeout=5)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.connect(self.path)


def port_of(control, link):
    """Of the link, as soon as it is open."""
    for _ in range(1000):
        try:
            connection = Control(control)
            connection.request("GET", "/status")
            for one in json.load(connection.getresponse())["links"]:
                if one["name"] == link and one["state"] == "up":
                    return one["port"]
        except (OSError, http.client.HTTPException):
            pass
        time.sleep(0.02)
    sys.exit("anogated does not answer")


def example(readme):
    """The indented block that begins with an import."""
    lines = pathlib.Path(source, readme).read_text(encoding="utf-8").splitlines()
    block = lines[lines.index("    import socket, sys"):]
    return [line[4:] for line in block[:next((i for i, line in enumerate(block) if not line.startswith("    ")), len(block))]]


with tempfile.TemporaryDirectory() as folder:
    control = folder + "/control"
    daemon = subprocess.Popen([anogated, "--control", control, "sim:fc", "udp-listen:127.0.0.1:0,name=ground"])
    try:
        port = port_of(control, "ground")
        codes = set()
        for readme in "include/ano/README.md", "include/ano/README.zh-CN.md":
            lines = example(readme)
            assert len(lines) == 15, f"{readme}: {len(lines)} lines"
            codes.add(re.sub(" *#.*", "", "\n".join(lines)))
            program = pathlib.Path(folder, "example.py")
            program.write_text("\n".join(lines), encoding="utf-8")
            ran = subprocess.run([sys.executable, program, str(port)], capture_output=True, text=True, timeout=30)
            assert (ran.returncode, ran.stdout) == (0, "0xDC is SimFC\n"), f"{readme}: {ran}"
        assert len(codes) == 1, "the two READMEs differ"
    finally:
        daemon.send_signal(signal.SIGTERM)
        daemon.wait()
