// All tests in a browser: node test/browser/run.mjs [FILE...]
// One browser for all. Two files at a time, each with its own gateway: the processor renders everything here, so more at a time
// would only wait for each other.
import { spawn } from "node:child_process";
import { existsSync, readdirSync, rmSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { launchBrowser, shots } from "./gateway.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const given = process.argv.slice(2);
const files = given.length > 0 ? given : readdirSync(here).filter((name) => name.endsWith(".test.mjs")).map((name) => join(here, name));
if (given.length === 0 && existsSync(shots)) for (const name of readdirSync(shots)) if (name.endsWith(".png")) rmSync(join(shots, name));

/** Runs the tests; returns their exit status, and the reason if the browser ended before them. */
async function run() {
  const browser = await launchBrowser();
  let ended, said = "";
  browser.process().on("exit", (status, signal) => { ended ??= `${signal ?? `status ${status}`}; its last words:\n${said}`; });
  browser.process().stderr.on("data", (words) => { said = (said + words).slice(-4000); }); // if unread, they would block it
  const tests = spawn(process.execPath, ["--test", "--test-reporter=spec", "--test-concurrency=2", ...files], {
    stdio: ["ignore", "inherit", "inherit"],
    env: { ...process.env, ANOGATE_BROWSER: browser.wsEndpoint() },
  });
  const status = await new Promise((done) => tests.on("exit", (code) => done(code ?? 1)));
  const outcome = { status, ended };
  ended ??= "";
  await browser.close().catch(() => undefined);
  return outcome;
}

let { status, ended } = await run();
if (status !== 0 && ended) {
  console.log(`the browser ended in the middle, by itself: all once more. ${ended}`);
  ({ status } = await run());
}
process.exitCode = status;
console.log(`pictures: ${shots}`);
