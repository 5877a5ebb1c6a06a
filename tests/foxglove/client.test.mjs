// What Foxglove's own client and its readers of ROS 2 messages make of a gateway with a simulated flight controller.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import ws_protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const { FoxgloveClient } = ws_protocol;
const token = "view-token-0123456789";
const folder = mkdtempSync(join(tmpdir(), "anogate-foxglove-"));
let gateway, port;

function start() {
  const process_of = spawn(process.env.ANOGATED, ["--control", join(folder, "control.sock"), "--config", join(folder, "anogate.json")]);
  return new Promise((resolve, reject) => {
    let said = "";
    process_of.on("exit", (code) => reject(new Error(`anogated ended with ${code}: ${said}`)));
    process_of.stderr.on("data", (data) => {
      said += data;
      const up = /http:\/\/127\.0\.0\.1:(\d+): up/.exec(said);
      if (up) resolve([process_of, Number(up[1])]);
    });
  });
}

function configure(links) {
  writeFileSync(join(folder, "anogate.json"), JSON.stringify({
    links,
    control: { http: "127.0.0.1:0", token_file: join(folder, "token"), origins: ["https://app.foxglove.dev"] },
  }));
}

before(async () => {
  writeFileSync(join(folder, "token"), `view ${token}\n`, { mode: 0o600 });
  configure(["sim:fc,name=fc"]);
  [gateway, port] = await start();
});
after(() => {
  gateway?.kill();
  rmSync(folder, { recursive: true });
});

// As a proxy passes it on, so that a token is needed whoever runs the test.
function socket(query, protocols = [FoxgloveClient.SUPPORTED_SUBPROTOCOL], headers = {}) {
  return new WebSocket(`ws://127.0.0.1:${port}/${query}`, protocols, { headers: { Via: "1.1 test", ...headers } });
}

// A client with all that it was told.
function client(query = `?token=${token}`, protocols = undefined) {
  const one = new FoxgloveClient({ ws: socket(query, protocols, { Origin: "https://app.foxglove.dev" }) });
  const told = { channels: new Map(), messages: [], statuses: [], parameters: [], info: undefined, error: undefined };
  one.on("serverInfo", (info) => { told.info = info; });
  one.on("advertise", (channels) => { for (const channel of channels) told.channels.set(channel.topic, channel); });
  one.on("unadvertise", (ids) => {
    for (const [topic, channel] of told.channels) if (ids.includes(channel.id)) told.channels.delete(topic);
  });
  one.on("message", (message) => told.messages.push(message));
  one.on("status", (status) => told.statuses.push(status));
  one.on("parameterValues", (values) => told.parameters.push(values));
  one.on("error", (error) => { told.error = error; });
  return [one, told];
}

async function until(what, holds) {
  const end = Date.now() + 20_000;
  for (;;) {
    const value = holds();
    if (value) return value;
    assert(Date.now() < end, `in vain: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 5));
  }
}

test("every channel is read by its schema", { timeout: 60_000 }, async () => {
  const [one, told] = client();
  await until("the flight controller's channels", () => told.channels.has("/fc/device_220/euler") && told.channels.has("/fc/device_220/inertial"));
  assert.deepEqual(told.info.capabilities, ["parameters", "parametersSubscribe"]);
  const readers = new Map(), read = new Map();
  for (const channel of told.channels.values()) {
    assert.equal(channel.encoding, "cdr");
    assert.equal(channel.schemaEncoding, "ros2msg");
    readers.set(one.subscribe(channel.id), [channel.topic, new MessageReader(parse(channel.schema, { ros2: true }))]);
  }
  await until("messages", () => told.messages.length > 200);
  for (const { subscriptionId, data, timestamp } of told.messages) {
    const [topic, reader] = readers.get(subscriptionId);
    read.set(topic, reader.readMessage(data));
    assert(Math.abs(Number(timestamp / 1_000_000n) - Date.now()) < 60_000);
  }
  assert(Math.abs(read.get("/fc/device_220/euler").rol) <= 180, JSON.stringify(read.get("/fc/device_220/euler")));
  const frame = read.get("/anogate/frames");
  assert.equal(frame.frame[0], 0xab);
  assert.equal(frame.link, "fc");
  assert.deepEqual(told.statuses, []);
  assert.equal(told.error, undefined);
  one.close();
});

test("messages as JSON say the same", { timeout: 60_000 }, async () => {
  const [one, told] = client(`?encoding=json&token=${token}`);
  const channel = await until("a channel", () => told.channels.get("/fc/device_220/euler"));
  assert.equal(channel.encoding, "json");
  assert.equal(JSON.parse(channel.schema).type, "object");
  one.subscribe(channel.id);
  const { data } = await until("a message", () => told.messages[0]);
  const euler = JSON.parse(new TextDecoder().decode(data));
  assert(Math.abs(euler.rol) <= 180, JSON.stringify(euler));
  one.close();
});

test("channels of a link that a reload removes are taken back, and come with it again", { timeout: 60_000 }, async () => {
  const subprotocols = [FoxgloveClient.SUPPORTED_SUBPROTOCOL, "foxglove.sdk.v1"];
  const clients = subprotocols.map((name) => client(undefined, [name]));
  for (const [, told] of clients) await until("channels", () => told.channels.has("/fc/device_220/euler"));
  const before = clients.map(([, told]) => told.channels.get("/fc/device_220/euler").id);
  const subscriptions = clients.map(([one], i) => one.subscribe(before[i]));
  configure([]);
  gateway.kill("SIGHUP");
  for (const [, told] of clients) {
    await until("the end of channels", () => !told.channels.has("/fc/device_220/euler"));
    assert.deepEqual([...told.channels.keys()], ["/anogate/frames"]);
  }
  clients.forEach(([one], i) => one.unsubscribe(subscriptions[i]));
  configure(["sim:fc,name=fc"]);
  gateway.kill("SIGHUP");
  for (const [i, [one, told]] of clients.entries()) {
    const channel = await until("channels", () => told.channels.get("/fc/device_220/euler"));
    assert.notEqual(channel.id, before[i]);
    const subscription = one.subscribe(channel.id);
    await until("messages", () => told.messages.some((message) => message.subscriptionId === subscription));
    assert.deepEqual(told.statuses, []);
    one.close();
  }
});

test("parameters are read, and not written", { timeout: 60_000 }, async () => {
  const [one, told] = client();
  await until("the flight controller", () => told.channels.has("/fc/device_220/euler"));
  one.getParameters(["fc/220/SIM_SWAY"], "question");
  const { parameters } = await until("the answer", () => told.parameters.find((values) => values.id === "question"));
  assert.equal(parameters.length, 1);
  assert.equal(parameters[0].type, "float64");
  one.setParameters([{ name: "fc/220/SIM_SWAY", value: 99 }], "write");
  const status = await until("a refusal", () => told.statuses[0]);
  assert.equal(status.level, 2);
  one.getParameters(["fc/220/SIM_SWAY"], "again");
  const again = await until("the answer", () => told.parameters.find((values) => values.id === "again"));
  assert.deepEqual(again.parameters, parameters);
  one.close();
});

// The status of the answer to who is not let in.
const refused = (one) => new Promise((resolve) => {
  one.on("unexpected-response", (_, answer) => resolve(answer.statusCode));
  one.on("open", () => resolve(101));
  one.on("error", () => {});
});

test("who may not come in is refused", { timeout: 60_000 }, async () => {
  assert.equal(await refused(socket("")), 401);
  assert.equal(await refused(socket("?token=wrong")), 401);
  assert.equal(await refused(socket(`?token=${token}`, undefined, { Origin: "https://evil.example" })), 403);
  assert.equal(await refused(socket(`?token=${token}`, undefined, { Host: "evil.example" })), 403);
  const sdk = socket(`?token=${token}`, ["foxglove.sdk.v1", FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
  assert.equal(await refused(sdk), 101);
  assert.equal(sdk.protocol, "foxglove.sdk.v1");
  sdk.close();
});

test("who comes again behind a restart finds another session", { timeout: 60_000 }, async () => {
  const [one, told] = client();
  await until("the greeting", () => told.info);
  const closed = new Promise((resolve) => one.on("close", resolve));
  gateway.removeAllListeners("exit");
  const ended = new Promise((resolve) => gateway.on("exit", resolve));
  gateway.kill();
  await Promise.all([closed, ended]);
  [gateway, port] = await start();
  const [another, again] = client();
  await until("the greeting", () => again.info);
  assert.notEqual(again.info.sessionId, told.info.sessionId);
  await until("channels", () => again.channels.has("/fc/device_220/euler"));
  another.close();
});
