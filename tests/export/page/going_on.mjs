// What two robots of a page find that is the same run, one of them a successor; and what one finds
// whose limit is moved.  node going_on.mjs PAGE.html
import { readFileSync } from "node:fs";
import vm from "node:vm";

const text = readFileSync(process.argv[2], "utf8");
const element = (id) => text.match(new RegExp(`<script[^>]*id="${id}"[^>]*>([^]*?)</script>`))[1];
vm.runInThisContext(`${element("alone")}; globalThis.page = { openEngine, planOf, chosenVariant };`);
const { openEngine, planOf, chosenVariant } = globalThis.page;

const told = JSON.parse(element("told")), engine = await openEngine(told, element("module"));
const { scene, variant } = chosenVariant(told, {}), law = told.laws[0].name;
const plan = () => planOf(told, scene, variant, law, {}, scene.start.slice());
const begun = (start) => engine.robot(variant.laws[law].loop).begin({ ...plan(), ...start }, told.seed);
const rows = (robot, count) => Array.from({ length: count }, () => (robot.sample(), Array.from(robot.row)));

const first = begun({});
rows(first, 4100);
const state = Float64Array.from(first.state), next = begun({ start: state });
next.resume(4100);
const same = JSON.stringify(rows(first, 50)) === JSON.stringify(rows(next, 50));
const before = first.finding("violations");
first.set({ "limits.v_u1[1]": 1e-3 });
rows(first, 1);
console.log(JSON.stringify({ same, before, after: first.finding("violations") }));
