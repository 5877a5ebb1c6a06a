import assert from "node:assert/strict";
import { test } from "node:test";
import { begin, endOf, Lines, type Job } from "../src/live/jobs";

test("takes whole lines out of what comes in pieces", () => {
  const lines = new Lines();
  assert.deepEqual(lines.put('{"a"'), []);
  assert.deepEqual(lines.put(':1}\n{"b":2}\n\n{"c'), ['{"a":1}', '{"b":2}']);
  assert.deepEqual(lines.end(), ['{"c']);
});

test("tells how a job ended, with its evidence", () => {
  assert.deepEqual(endOf({ id: 1, kind: "apply", state: "done", message: "", result: 5 }), { ok: true, value: 5, status: 200 });
  const failed = endOf({ id: 1, kind: "apply", state: "failed", message: "no", error: "no answer", what: "timeout", status: 504, evidence: { sent: 5 }, result: { parameters: [] } });
  assert.ok(!failed.ok);
  assert.deepEqual([failed.refusal.status, failed.refusal.error, failed.refusal.evidence, failed.refusal.body], [504, "no answer", { sent: 5 }, { parameters: [] }]);
  const cancelled = endOf({ id: 1, kind: "scan", state: "cancelled", message: "" });
  assert.equal(!cancelled.ok && cancelled.refusal.error, "cancelled");
});

/** The answers of the gateway, in order of the requests; "gone": it is not reachable. */
async function answered(answers: (Job | "gone" | 404)[]): Promise<{ told: string[]; end: Awaited<ReturnType<typeof begin>> }> {
  const before = { fetch: globalThis.fetch, location: globalThis.location, setTimeout: globalThis.setTimeout };
  Object.assign(globalThis, {
    location: { pathname: "/" },
    setTimeout: (call: () => void) => before.setTimeout(call, 0),
    fetch: async () => {
      const next = answers.shift();
      if (next === undefined || next === "gone") throw new TypeError("Failed to fetch");
      return next === 404 ? new Response("{}", { status: 404 }) : new Response(JSON.stringify(next) + "\n");
    },
  });
  const told: string[] = [];
  const end = await begin("/devices/220/calibration", {}, (job) => told.push(job.message));
  Object.assign(globalThis, before);
  return { told, end };
}

const calibration: Job = { id: 1, kind: "calibration", device: "0xDC", state: "running", message: "" };

test("a job goes on over a lost contact, to its own end", async () => {
  const { told, end } = await answered([{ ...calibration, message: "begun" }, "gone", "gone", { ...calibration, message: "goes on" }, "gone", { ...calibration, state: "done", message: "ended", result: 5 }]);
  assert.deepEqual(told, ["begun", "goes on", "ended"]);
  assert.deepEqual(end, { ok: true, value: 5, status: 200 });
});

test("the job of another is not taken for one that a restarted gateway no longer knows", async () => {
  for (const now of [404, { ...calibration, kind: "command", state: "done", result: 5 }, { ...calibration, device: "0xDD", state: "done", result: 5 }] as const) {
    const { told, end } = await answered([{ ...calibration, message: "begun" }, "gone", now]);
    assert.deepEqual(told, ["begun"]);
    assert.equal(!end.ok && end.refusal.what, "no_contact", "nobody knows how it ended");
  }
});
