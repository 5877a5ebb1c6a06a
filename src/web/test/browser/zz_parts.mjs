import { readdirSync, readFileSync } from "node:fs";
import http from "node:http";
import { Gateway } from "./gateway.mjs";
import { Traffic } from "./traffic.mjs";
const pause = (s) => new Promise((d) => setTimeout(d, s * 1000));
const used = (pid) => readdirSync(`/proc/${pid}/task`).reduce((sum, thread) => sum + Number(readFileSync(`/proc/${pid}/task/${thread}/schedstat`, "utf8").split(" ")[0]) / 1e9, 0);
const gateway = await Gateway.start(["udp-listen:127.0.0.1:0,name=vehicle", "udp-listen:127.0.0.1:0,name=ground"]);
const token = gateway.token("control");
const agent = new http.Agent({ keepAlive: true, maxSockets: 1 });
const get = (path) => new Promise((done, fail) => http.get(gateway.address + path, { agent, headers: { Authorization: "Bearer " + token } }, (r) => { let s = ""; r.on("data", (d) => (s += d)); r.on("end", () => done(s)); }).on("error", fail));
const links = JSON.parse(await get("/links"));
const port = (name) => links.find((l) => l.name === name).port;
const traffic = new Traffic();
traffic.begin(port("vehicle"), port("ground"), Number(process.argv[2]));
await pause(1);
const pid = gateway.process.pid;
const measure = async (s) => { const a = used(pid), b = performance.now(); await pause(s); return (used(pid) - a) / ((performance.now() - b) / 1000) * 1000; };
const every = (path, ms) => { const t = setInterval(() => get(path), ms); return () => clearInterval(t); };
const ws = (query) => { const s = new WebSocket(gateway.address.replace("http", "ws") + "/frames?" + query, { headers: { Authorization: "Bearer " + token } }); s.binaryType = "arraybuffer"; s.onerror = (e) => console.log("error", e.message); return () => s.close(); };
const parts = { "status 1/s": () => every("/status", 1000), "jobs 2/s": () => every("/jobs", 500), "jobs 20/s": () => every("/jobs", 50), "devices 1/2s": () => every("/devices", 2000), "status 20/s": () => every("/status", 50),
 "charts 50": () => ws("format=binary&batch=50ms&direction=in&from=220,221,222,223&id=1,3,4"), "charts 100": () => ws("format=binary&batch=100ms&direction=in&from=220,221,222,223&id=1,3,4"), "all 50": () => ws("format=binary&batch=50ms&direction=in"), "charts 25": () => ws("format=binary&batch=25ms&direction=in&id=1") };
for (const [name, begin] of Object.entries(parts)) {
  const d = [];
  let base = [];
  for (let i = 0; i < 5; ++i) { const a = await measure(1.5); const end = begin(); await pause(0.3); const b = await measure(2); end(); await pause(0.2); base.push(a); d.push(b - a); }
  d.sort((a, b) => a - b); base.sort((a, b) => a - b);
  console.log(name.padEnd(14), "base", base[2].toFixed(2), "+", d.map((x) => x.toFixed(2)).join(" "), "ms/s");
}
traffic.end(); await gateway.end(); process.exit(0);
