import assert from "node:assert/strict";
import { test } from "node:test";
import { follow, type Job } from "../src/live/jobs";
import { rangeOf, valuesOf } from "../src/parts/command_values";
import { isCalibration } from "../src/parts/parameter_set";
import { messageInChinese, reasonInChinese } from "../src/words_of_device";

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

test("says in Chinese what the gateway says of jobs, and leaves what it does not know", () => {
  assert.equal(messageInChinese("reading parameters"), "正在读取参数");
  assert.equal(messageInChinese("sending, 12.3 KB/s, 40 s left"), "正在发送固件，12.3 KB/秒，还要 40 秒");
  assert.equal(messageInChinese("calling LAND"), "正在执行 LAND");
  assert.equal(messageInChinese("The old values are saved. Continue when you are ready to turn the device"), "旧值已保存。准备好转动设备后请继续");
  assert.equal(messageInChinese("checking the new values: keep it still on -y"), "正在验证新值：请保持 -y 朝上不动");
  assert.equal(messageInChinese("checking the new values: lay it on +z and keep it still"), "正在验证新值：请再让 +z 朝上静置");
  assert.equal(reasonInChinese("no answer to LAND: it may have been carried out"), "没有收到对 LAND 的确认：它可能已经执行了");
  assert.equal(reasonInChinese("0xDC is used by job 7 (firmware upgrade, by 192.168.1.5)"), "0xDC 正被任务 7（固件升级，来自 192.168.1.5）占用");
  assert.equal(reasonInChinese("0x1E is online, but did not answer the request for its number of commands, sent 5 times; it probably has none"), "0x1E 在线，但没有应答对 number of commands 的请求，已发送 5 次");
  assert.equal(reasonInChinese("/rec: only 1.0 MB of disk space is free, and recording needs 500.0 MB: 495.0 MB to keep free (record.free) and 5 MB"), "/rec：磁盘只剩 1.0 MB，至少需要 500.0 MB 才能继续录制");
  assert.equal(reasonInChinese("/mnt/a.pcapng: Read-only file system"), "/mnt/a.pcapng：文件系统只读");
  assert.equal(reasonInChinese("something new"), "something new");
});

test("knows what belongs to one piece of hardware", () => {
  assert.deepEqual(["CAL_AOFF_X", "SIM_WIND"].map(isCalibration), [true, false]);
});
