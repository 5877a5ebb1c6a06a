import assert from "node:assert/strict";
import { test } from "node:test";
import { onHeard } from "../src/api";
import { Connection, reopenAll, retryAfter, retryHidden, type ConnectionUser } from "../src/live/connection";

class FakeSocket {
  static all: FakeSocket[] = [];
  isClosed = false;
  onopen = (): void => undefined;
  onclose = (): void => undefined;
  onmessage = (_: { data: string | ArrayBuffer }): void => undefined;
  constructor(readonly address: string) {
    FakeSocket.all.push(this);
  }
  close(): void {
    this.isClosed = true;
  }
}

/** A browser with one connection of the page, in simulated time. */
function browser() {
  let now = 0;
  const timers = new Map<number, { at: number; call: () => void }>(), looks: (() => void)[] = [];
  const page = { hidden: false, addEventListener: (_: string, look: () => void) => looks.push(look) };
  FakeSocket.all = [];
  Object.assign(globalThis, { document: page, location: { protocol: "http:", host: "gateway", pathname: "/" }, WebSocket: FakeSocket });
  const kept = { setTimeout: globalThis.setTimeout, clearTimeout: globalThis.clearTimeout };
  let timer = 0;
  Object.assign(globalThis, { setTimeout: (call: () => void, after: number) => (timers.set(++timer, { at: now + after, call }), timer), clearTimeout: (one: number) => timers.delete(one) });
  const heard: (string | ArrayBuffer)[] = [];
  let opened = 0;
  const user: ConnectionUser = { route: "/frames", opened: () => void ++opened, take: (message) => heard.push(message) };
  return {
    user, heard, sockets: FakeSocket.all, connection: new Connection(),
    get opened() { return opened; },
    get last() { return FakeSocket.all[FakeSocket.all.length - 1]!; },
    hide: (hidden: boolean) => ((page.hidden = hidden), looks.forEach((look) => look())),
    pass: (milliseconds: number) => {
      now += milliseconds;
      for (const [key, { at, call }] of [...timers]) if (at <= now && timers.delete(key)) call();
    },
    end: () => Object.assign(globalThis, kept),
  };
}

function inBrowser(name: string, look: (it: ReturnType<typeof browser>) => void): void {
  test(name, () => {
    const it = browser();
    try {
      look(it);
    } finally {
      it.connection.close();
      it.end();
    }
  });
}

inBrowser("a connection is opened once, and gives on what comes", (it) => {
  let gatewayHeard = 0;
  onHeard.call = () => ++gatewayHeard;
  it.connection.open(it.user);
  it.connection.open(it.user);
  assert.deepEqual(it.sockets.map((one) => one.address), ["ws://gateway/frames"]);
  it.last.onopen();
  it.last.onmessage({ data: "{}" });
  assert.deepEqual([it.opened, it.heard, gatewayHeard], [1, ["{}"], 1]);
});

inBrowser("one that breaks is opened again after a while, as often as it breaks", (it) => {
  it.connection.open(it.user);
  for (let broken = 1; broken <= 3; ++broken) {
    it.last.onclose();
    it.pass(retryAfter - 1);
    assert.equal(it.sockets.length, broken);
    it.pass(1);
    assert.equal(it.sockets.length, broken + 1);
  }
});

inBrowser("one that is closed stays so, and says nothing more", (it) => {
  it.connection.open(it.user);
  const first = it.last;
  it.connection.close();
  assert.ok(first.isClosed);
  first.onopen();
  first.onmessage({ data: "late" });
  first.onclose();
  it.pass(10 * retryAfter);
  it.hide(true);
  it.hide(false);
  reopenAll();
  assert.deepEqual([it.sockets.length, it.opened, it.heard], [1, 0, []]);
  it.connection.open(it.user);
  it.last.onclose();
  it.connection.close(); // while it waits to be opened again
  it.pass(10 * retryAfter);
  assert.equal(it.sockets.length, 2);
});

inBrowser("all are opened anew at once, and the old ones' ends open no further", (it) => {
  it.connection.open(it.user);
  const first = it.last;
  reopenAll();
  assert.ok(first.isClosed);
  assert.equal(it.sockets.length, 2);
  first.onmessage({ data: "late" });
  first.onclose();
  it.pass(10 * retryAfter);
  assert.deepEqual([it.sockets.length, it.heard], [2, []]);
  it.last.onclose();
  reopenAll(); // it no longer waits
  assert.equal(it.sockets.length, 3);
  it.pass(retryAfter / 2);
  it.last.onclose();
  it.pass(retryAfter - 1);
  assert.equal(it.sockets.length, 3);
  it.pass(1);
  assert.equal(it.sockets.length, 4);
});

inBrowser("one that says so stays open while the page is hidden, and is opened again more seldom", (it) => {
  let closed = 0;
  it.connection.open({ ...it.user, whileHidden: true, closed: () => ++closed });
  it.hide(true);
  assert.equal(it.last.isClosed, false);
  it.last.onmessage({ data: "{}" });
  assert.deepEqual(it.heard, ["{}"]);
  it.last.onclose();
  assert.equal(closed, 1);
  it.pass(retryHidden - 1);
  assert.equal(it.sockets.length, 1);
  it.pass(1);
  assert.equal(it.sockets.length, 2);
  it.last.onclose();
  it.hide(false); // immediately
  assert.equal(it.sockets.length, 3);
  it.hide(true);
  reopenAll();
  assert.equal(it.sockets.length, 4);
});

inBrowser("a hidden page has no other connection, and has it again when it is shown", (it) => {
  it.connection.open(it.user);
  it.hide(true);
  assert.ok(it.last.isClosed);
  reopenAll();
  it.pass(10 * retryAfter);
  assert.equal(it.sockets.length, 1);
  it.hide(false);
  assert.equal(it.sockets.length, 2);
  it.last.onclose();
  it.hide(true); // while it waits to be opened again
  it.pass(10 * retryAfter);
  assert.equal(it.sockets.length, 2);
});
