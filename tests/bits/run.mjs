// Runs the cases of a WebAssembly module; what it puts goes to the standard output.
import { readFileSync, writeSync } from "node:fs";

const put = (at, size) => writeSync(1, new Uint8Array(exports.memory.buffer, at, size)) === size;
const module = new WebAssembly.Module(readFileSync(process.argv[2]));
const { exports } = new WebAssembly.Instance(module, { env: { put } });
process.exitCode = exports.run();
