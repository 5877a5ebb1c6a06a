// Builds the page: node build.mjs [--out DIR] [--modules DIR] [--tests]
// Files are named by their content, so that a browser may keep them for ever, and compressed beforehand.
import { createHash } from "node:crypto";
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));
const option = (name, usual) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? usual : resolve(process.argv[at + 1]);
};
const tests = process.argv.includes("--tests");
const out = option("--out", join(here, "build", tests ? "tests" : "page"));
const modules = option("--modules", join(here, "node_modules"));
const { build } = createRequire(join(modules, "x.js"))("esbuild");

const most = 150 * 1024; // bytes of all files together, compressed

const common = { bundle: true, format: "esm", charset: "utf8", jsx: "automatic", jsxImportSource: "preact", nodePaths: [modules], logLevel: "warning", absWorkingDir: here };

async function buildTests() {
  const entryPoints = readdirSync(join(here, "test")).filter((name) => name.endsWith(".test.ts")).map((name) => join(here, "test", name));
  rmSync(out, { recursive: true, force: true });
  await build({ ...common, entryPoints, outdir: out, platform: "node", outExtension: { ".js": ".mjs" }, define: { "import.meta.dirname": JSON.stringify(join(here, "test")) } });
}

async function buildPage() {
  const result = await build({
    ...common,
    entryPoints: [join(here, "src/main.tsx"), join(here, "src/style.css")],
    outdir: out,
    write: false,
    minify: true,
    target: ["es2020"],
    legalComments: "none",
    entryNames: "[name]",
  });
  rmSync(out, { recursive: true, force: true });
  mkdirSync(out, { recursive: true });
  let total = 0;
  const write = (name, content) => {
    const packed = gzipSync(content, { level: 9 });
    packed.fill(0, 4, 8); // no time: the same page has the same bytes
    total += packed.length;
    writeFileSync(join(out, name + ".gz"), packed);
  };
  const named = (stem, ending, content) => {
    const name = `${stem}-${createHash("sha256").update(content).digest("hex").slice(0, 12)}.${ending}`;
    write(name, content);
    return "web/" + name;
  };
  const content = (name) => Buffer.from(result.outputFiles.find((file) => file.path.endsWith("/" + name)).contents);
  const html = readFileSync(join(here, "index.html"), "utf8")
    .replace("@icon@", named("icon", "svg", readFileSync(join(here, "icon.svg"))))
    .replace("@style@", named("page", "css", content("style.css")))
    .replace("@script@", named("page", "js", content("main.js")));
  write("index.html", html);
  console.log(`page: ${out}, ${(total / 1024).toFixed(1)} KB compressed`);
  if (total > most) throw new Error(`the page is larger than ${most / 1024} KB compressed`);
}

await (tests ? buildTests() : buildPage());
