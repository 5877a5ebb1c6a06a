// npm run test:browser -- --anogated PATH [words of a test's name]
import { spawnSync } from "node:child_process";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const words = process.argv.slice(2);
const at = words.indexOf("--anogated");
if (at < 0 || !words[at + 1]) {
  console.error("npm run test:browser -- --anogated PATH [words of a test's name]");
  process.exit(2);
}
const [, program] = words.splice(at, 2);
const only = words.length > 0 ? ["--test-name-pattern", words.join(" ")] : [];
const file = join(dirname(fileURLToPath(import.meta.url)), "page.test.mjs");
const ended = spawnSync(process.execPath, ["--test", ...only, file], { stdio: "inherit", env: { ...process.env, ANOGATED: resolve(program) } });
process.exit(ended.status ?? 1);
