import assert from "node:assert/strict";
import { test } from "node:test";
import { follow, type Job } from "../src/live/jobs";
import { rangeOf, valuesOf } from "../src/parts/command_values";
import { isCalibration } from "../src/parts/parameter_set";
import { faults } from "../src/faults";
import { faultInChinese } from "../src/i18n";
import { messageInChinese } from "../src/words_of_device";

const page = globalThis as { location?: unknown; fetch: unknown };
page.location ??= { pathname: "/", hash: "" };

/** A gateway with these answers in order: lines followed by the end of the connection, or a refusal. */
function gateway(...answers: (string[] | { status: number; body: string })[]): string[] {
  const asked: string[] = [];
  page.fetch = async (route: string) => {
    asked.push(route);
    const answer = answers.shift();
    if (!answer) throw new Error("nobody is there");
    return Array.isArray(answer) ? new Response(answer.map((line) => line + "\n").join("")) : new Response(answer.body, { status: answer.status });
  };
  return asked;
}

test("finds a job again when the contact was lost, and tells how it ended", async () => {
  const asked = gateway(['{"id": 7, "state": "running", "progress": 0.5, "message": ""}'], { status: 503, body: "" }, ['{"id": 7, "state": "done", "message": "", "result": {"bytes": 5}}']);
  const seen: Job[] = [];
  // "Busy" (503) is an answer: it is reported, and the request is not repeated for ever.
  const full = await follow("/devices/220/firmware", { method: "POST" }, (job) => seen.push(job));
  assert.equal(full.ok, false);
  assert.deepEqual(asked, ["/devices/220/firmware", "/jobs/7"]);
  gateway(['{"id": 8, "state": "running", "message": ""}'], ['{"id": 8, "state": "done", "message": "", "result": {"bytes": 5}}']);
  assert.deepEqual(await follow("/devices/220/apply", { method: "POST" }, () => undefined), { ok: true, value: { bytes: 5 }, status: 200 });
});

test("a job that the gateway no longer knows ended nobody knows how; what never began is not asked for again", async () => {
  gateway(['{"id": 7, "state": "running", "message": ""}'], { status: 404, body: '{"error": "there is no job 7"}' });
  const gone = await follow("/devices/220/apply", {}, () => undefined);
  assert.equal(!gone.ok && gone.refusal.status, 0);
  const asked = gateway();
  const never = await follow("/devices/220/apply", {}, () => undefined);
  assert.equal(!never.ok && never.refusal.status, 0);
  assert.equal(asked.length, 1);
});

test("a command's values fit the types that the device declares", () => {
  assert.deepEqual(rangeOf("i16"), [-32768, 32767]);
  assert.equal(rangeOf("f32"), undefined);
  assert.deepEqual(valuesOf(["u8", "i8", "f32"], ["255", "-128", "1.5"]), [255, -128, 1.5]);
  for (const [type, text] of [["u8", "256"], ["u8", "-1"], ["i8", "128"], ["u16", "1.5"], ["f32", "x"]] as const) assert.equal(valuesOf([type], [text]), undefined, `${type} ${text}`);
  assert.deepEqual(valuesOf(["u64"], ["18446744073709551615"]), ["18446744073709551615"]);
});

test("says in Chinese what jobs do", () => {
  assert.equal(messageInChinese("reading parameters"), "正在读取参数");
  assert.equal(messageInChinese("sending, 12.3 KB/s, 40 s left"), "正在发送固件，12.3 KB/秒，还要 40 秒");
  assert.equal(messageInChinese("calling LAND"), "正在执行 LAND");
  assert.equal(messageInChinese("The old values are saved. Continue when you are ready to turn the device"), "旧值已保存。准备好转动设备后请继续");
  assert.equal(messageInChinese("checking the new values: keep it still on -y"), "正在验证新值：请保持 -y 朝上不动");
  assert.equal(messageInChinese("checking the new values: lay it on +z and keep it still"), "正在验证新值：请再让 +z 朝上静置");
});

test("says in Chinese why something failed, by its id", () => {
  const job = { error_id: "job_by", error_args: { number: "7", action: { error_id: "firmware_upgrade", error_args: {} }, client: "192.168.1.5" } };
  assert.equal(faultInChinese({ error_id: "used_by_job", error_args: { device: "0xDC", job } }), "0xDC 正被任务 7（固件升级，来自 192.168.1.5）占用");
  assert.equal(faultInChinese({ error_id: "may_be_executed", error_args: { command: "LAND" } }), "没有收到对 LAND 的确认：它可能已经执行了");
  const remarks = [{ error_id: "old_values_restored", error_args: {} }, { error_id: "other_writer", error_args: { writer: "0xFE", device: "0xDC" } }];
  assert.equal(faultInChinese({ error_id: "cancelled", error_args: {}, error_remarks: remarks }), "已取消；旧值已恢复；0xFE 也在写入 0xDC");
});

test("leaves in English what it does not know: an id, or that of an argument or a remark", () => {
  assert.equal(faultInChinese({ error: "something new" }), undefined);
  assert.equal(faultInChinese({ error_id: "something_new", error_args: {} }), undefined);
  assert.equal(faultInChinese({ error_id: "rejected", error_args: { why: { error_id: "something_new" } } }), undefined);
  assert.equal(faultInChinese({ error_id: "cancelled", error_args: {}, error_remarks: [{ error_id: "something_new" }] }), undefined);
  assert.equal(Object.keys(faults).includes("something_new"), false);
});

test("knows what belongs to one piece of hardware", () => {
  assert.deepEqual(["CAL_AOFF_X", "SIM_WIND"].map(isCalibration), [true, false]);
});
