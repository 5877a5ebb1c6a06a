import assert from "node:assert/strict";
import { test } from "node:test";
import { endOf, Lines } from "../src/live/jobs";

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
