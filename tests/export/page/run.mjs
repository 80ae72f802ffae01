// Runs the scripts of a page that need no document; writes the bits of the columns that are asked for.
// node run.mjs PAGE.html REQUESTS.json OUT: requests are [law, seconds, overrides]; OUT gets for each a
// line of JSON (names and samples) and OUT.bin all columns as doubles.
import { readFileSync, writeFileSync } from "node:fs";
import vm from "node:vm";

const [, , page, requests, out] = process.argv;
const text = readFileSync(page, "utf8");
const element = (id) => text.match(new RegExp(`<script[^>]*id="${id}"[^>]*>([^]*?)</script>`))[1];

vm.runInThisContext(`${element("alone")}; globalThis.page = { openEngine, runColumns };`);
const engine = await globalThis.page.openEngine(JSON.parse(element("told")), element("module"));
const lines = [], parts = [];
for (const [law, seconds, overrides] of JSON.parse(readFileSync(requests, "utf8"))) {
  try {
    const columns = await globalThis.page.runColumns(engine, law, seconds, overrides);
    const names = Object.keys(columns);
    lines.push({ names, samples: columns[names[0]].length });
    for (const name of names) parts.push(Buffer.from(columns[name].buffer, columns[name].byteOffset, columns[name].byteLength));
  } catch (error) {
    lines.push({ error: error.message });
  }
}
writeFileSync(out, lines.map((line) => JSON.stringify(line)).join("\n"));
writeFileSync(`${out}.bin`, Buffer.concat(parts));
