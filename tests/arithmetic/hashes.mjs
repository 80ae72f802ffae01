// Prints what hash_of in a WebAssembly module without imports makes of each function.
import { readFileSync } from "node:fs";

const module = new WebAssembly.Module(readFileSync(process.argv[2]));
if (WebAssembly.Module.imports(module).length) throw new Error("the module has imports");
const { hash_of } = new WebAssembly.Instance(module, {}).exports;
for (let which = 0, hash; (hash = BigInt.asUintN(64, hash_of(which))); ++which) {
  console.log(hash.toString(16).padStart(16, "0"));
}
